% Derivatives of a rod between two points of two bodies, by hand:
% Phi = (|d|^2 - l^2) / (2 l) with d = r_b + R_b s_b - r_a - R_a s_a and b = [s_a, s_b, l].
function row = phi_q(q, b)
    arm = @(angle, x, y) [cos(angle) * x - sin(angle) * y, sin(angle) * x + cos(angle) * y];
    ra = arm(q(3), b(1), b(2));
    rb = arm(q(6), b(3), b(4));
    d = [q(4) + rb(1) - q(1) - ra(1), q(5) + rb(2) - q(2) - ra(2)];
    row = [-d, -d * [-ra(2); ra(1)], d, d * [-rb(2); rb(1)]] / b(5);
end
