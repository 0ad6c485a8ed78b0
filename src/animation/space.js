  // A scene in space: projection, faces sorted by depth (painter's algorithm), and the pointer.
  const draw = (() => {
    const canvas = at("picture"), pen = canvas.getContext("2d"), tip = at("tip");
    const plus = (a, b, s = 1) => [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]];
    const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    const unitOf = a => { const l = Math.hypot(...a) || 1; return a.map(x => x / l); };
    const middle = points => points.reduce((sum, p) => plus(sum, p, 1 / points.length), [0, 0, 0]);
    const triples = (list, from = 0) => {
      const points = [];
      for (let i = from; i + 2 < list.length; i += 3) points.push([list[i], list[i + 1], list[i + 2]]);
      return points;
    };
    const [low, high] = data.bounds, target = middle([low, high]);
    const size = Math.max(...plus(high, low, -1)) || 1, reach = Math.max(Math.hypot(...plus(high, low, -1)) / 2, size / 2) || 1;

    // Long faces are cut across, and long lines, so that their parts are sorted well. Every face knows which of its sides are edges.
    const cut = face => {
      const [a, b, c, d] = face, sides = face.map(() => true);
      if (face.length !== 4) return [{ points: face, sides }];
      const lengths = [Math.hypot(...plus(b, a, -1)), Math.hypot(...plus(c, b, -1))];
      const n = Math.min(8, Math.max(1, Math.round(Math.max(...lengths) / Math.max(Math.min(...lengths), size / 12))));
      const along = (p, q, k) => plus(p, plus(q, p, -1), k / n);
      return Array.from({ length: n }, (_, k) => lengths[0] > lengths[1]
        ? { points: [along(a, b, k), along(a, b, k + 1), along(d, c, k + 1), along(d, c, k)], sides: [true, k === n - 1, true, k === 0] }
        : { points: [along(a, d, k), along(b, c, k), along(b, c, k + 1), along(a, d, k + 1)], sides: [k === 0, true, k === n - 1, true] });
    };
    const segments = points => points.slice(1).flatMap((q, i) => {
      const p = points[i], n = Math.min(12, Math.max(1, Math.ceil(12 * Math.hypot(...plus(q, p, -1)) / size)));
      return Array.from({ length: n }, (_, k) => [plus(p, plus(q, p, -1), k / n), plus(p, plus(q, p, -1), (k + 1) / n)]);
    });
    const groups = data.groups.map(group => ({
      poses: group.poses,
      parts: group.parts.map(part => ({
        name: part.name, colour: part.colour, body: !!part.trail, flat: !!part.flat, trail: part.trail,
        faces: (part.faces || []).flatMap(face => cut(triples(face))),
        lines: (part.lines || []).flatMap(line => segments(triples(line, 1)).map(points => ({ width: line[0], points }))),
        balls: (part.balls || []).map(ball => ({ radius: ball[0], at: ball.slice(1) })),
      })),
    }));
    const value = (column, place) => typeof column === "number" ? column : between(column, place);
    const poseAt = (group, place) => {
      const [x, y, z, ...e] = group.poses.map(column => value(column, place)), l = Math.hypot(...e) || 1;
      const [a, b, c, d] = e.map(x => x / l);
      const rows = [[1 - 2 * (c * c + d * d), 2 * (b * c - a * d), 2 * (b * d + a * c)],
        [2 * (b * c + a * d), 1 - 2 * (b * b + d * d), 2 * (c * d - a * b)], [2 * (b * d - a * c), 2 * (c * d + a * b), 1 - 2 * (b * b + c * c)]];
      return p => [x + dot(rows[0], p), y + dot(rows[1], p), z + dot(rows[2], p)];
    };
    const frames = times.map((_, k) => [k, k, 0]);
    const trails = groups.flatMap(group => group.parts.filter(part => part.trail && group.poses.some(column => typeof column !== "number"))
      .map(part => ({ name: part.name, colour: part.colour, group, at: part.trail, points: frames.map(place => poseAt(group, place)(part.trail)) })));

    // The view: the angles of the eye, magnification, and displacement in the picture.
    const up = data.up, right = unitOf(plus(Math.abs(up[0]) > .9 ? [0, 1, 0] : [1, 0, 0], up, -(Math.abs(up[0]) > .9 ? up[1] : up[0])));
    const away = cross(up, right), start = { turn: data.view[0], tilt: data.view[1], zoom: 1, move: [0, 0] };
    let view = { ...start, move: [0, 0] }, fit = { scale: 1, at: [0, 0] }, wide = 1, tall = 1, axes = [];
    const aim = () => {
      const [s, c, st, ct] = [Math.sin(view.turn), Math.cos(view.turn), Math.sin(view.tilt), Math.cos(view.tilt)];
      const ahead = plus(right.map(x => -s * x), away, c);
      axes = [plus(right.map(x => c * x), away, s), plus(up.map(x => ct * x), ahead, st), plus(up.map(x => st * x), ahead, -ct)];
    };
    const distance = 4.5 * reach;
    // The position in the picture, and the depth toward the eye.
    const seen = p => {
      const q = plus(p, target, -1), z = dot(axes[2], q), s = distance / Math.max(distance - z, .05 * distance) * fit.scale * view.zoom;
      return [wide / 2 + view.move[0] + s * dot(axes[0], q) + fit.at[0] * view.zoom, tall / 2 + view.move[1] - s * dot(axes[1], q) + fit.at[1] * view.zoom, z, s];
    };

    // The floor below the lowest point, with lines at a distance of 1, 2 or 5 times a power of ten.
    const level = data.floor - .015 * size, power = 10 ** Math.floor(Math.log10(size / 5));
    const step = power * [1, 2, 5, 10].find(x => x * power >= size / 8), corners = [0, 1, 2, 3, 4, 5, 6, 7].map(k => [0, 1, 2].map(i => (k >> i & 1 ? high : low)[i]));
    const range = axis => {
      const all = corners.map(p => dot(axis, p)), margin = .02 * size;
      const first = Math.floor((Math.min(...all) - margin) / step);
      return Array.from({ length: Math.min(50, Math.ceil((Math.max(...all) + margin) / step) - first + 1) }, (_, k) => first + k);
    };
    const ranges = [range(right), range(away)];
    const floorAt = (x, y) => plus(plus(up.map(x => level * x), right, x), away, y);
    const ends = list => [list[0], list[list.length - 1]];
    const grid = [...ranges[0].map(x => ends(ranges[1]).map(y => floorAt(x * step, y * step))),
      ...ranges[1].map(y => ends(ranges[0]).map(x => floorAt(x * step, y * step)))];
    const ground = p => plus(p, up, level - dot(up, p));

    // The axes of the inertial frame, at the origin if it is not far away.
    const near = low.every((x, i) => x - size < 0 && high[i] + size > 0), origin = near ? [0, 0, 0] : low;
    const frame = ["x", "y", "z"].map((name, i) => ({ name, colour: data.axes[i], tip: origin.map((x, k) => x + (k === i ? .14 * size : 0)) }));

    const colours = { };
    const readColours = () => { for (const name of ["ink", "metal", "grid", "shadow", "text", "panel"]) colours[name] = getComputedStyle(canvas).getPropertyValue("--" + name).trim(); };
    const rgb = text => [1, 3, 5].map(i => parseInt(text.length < 7 ? text[(i + 1) / 2].repeat(2) : text.slice(i, i + 2), 16));
    const shaded = (text, light) => `rgb(${rgb(text).map(x => Math.round(Math.min(255, x * light)))})`;
    const colourOf = (part, solid) => part.colour === "ink" ? colours[solid ? "metal" : "ink"] : part.colour;
    const LIGHT = unitOf([-.35, .8, .55]);

    let items = [], lit = null, last = [0, 0, 0];
    const collect = place => {
      items = [];
      const shadows = [], moved = groups.map(group => poseAt(group, place));
      const add = (points, item, behind = 0) => {
        const xy = points.map(seen);
        items.push({ ...item, xy, z: xy.reduce((sum, p) => sum + p[2], 0) / xy.length - behind });
      };
      groups.forEach((group, k) => group.parts.forEach(part => {
        const body = part.body ? 1 : 0;
        for (const { points, sides } of part.faces) {
          const world = points.map(moved[k]), normal = unitOf(cross(plus(world[1], world[0], -1), plus(world[2], world[0], -1)));
          if (part.body && (part.flat || dot(normal, up) > 1e-6)) shadows.push(world.map(ground));
          const toward = dot(normal, plus(plus(target, axes[2], distance), world[0], -1));
          if (!part.flat && toward <= 0) continue;
          const sign = toward < 0 ? -1 : 1, light = .68 + .5 * Math.max(0, dot(LIGHT, axes.map(axis => sign * dot(axis, normal))));
          add(world, { kind: "face", name: part.name, fill: shaded(colourOf(part, true), light), edge: shaded(colourOf(part, true), .6 * light), sides, body });
        }
        for (const { points, width } of part.lines) {
          // Lines inside a body are behind its faces.
          const isInside = part.colour !== "ink" && !part.body;
          add(points.map(moved[k]), { kind: "line", name: part.name, fill: colourOf(part), width }, isInside ? .05 * size : 0);
        }
        for (const { at, radius } of part.balls) add([moved[k](at)], { kind: "ball", name: part.name, fill: colourOf(part, true), radius });
      }));
      for (const { name, width, ends } of data.links) {
        const points = ends.map(([group, ...p]) => moved[group](p));
        segments(points).forEach(points => add(points, { kind: "line", name, fill: colours.ink, width }));
      }
      for (const { name, colour, tip } of frame) {
        segments([origin, tip]).forEach(points => add(points, { kind: "line", name: "inertial frame", fill: colour, width: .4 * data.unit }));
        add([plus(tip, plus(tip, origin, -1), .18)], { kind: "text", name, fill: colour });
      }
      items.sort((a, b) => a.z - b.z);
      return shadows;
    };
    const path = (points, closed) => { pen.beginPath(); points.forEach(([x, y], i) => i ? pen.lineTo(x, y) : pen.moveTo(x, y)); if (closed) pen.closePath(); };
    const paint = (item, alpha) => {
      pen.globalAlpha = (lit && item.name !== lit ? .18 : 1) * alpha ;
      pen.fillStyle = item.fill; pen.strokeStyle = item.fill;
      const { xy } = item, [x, y, , s] = xy[0];
      if (item.kind === "text") { pen.fillText(item.name, x, y); return; }
      if (item.kind === "ball") {
        const r = Math.max(2, item.radius * s), shine = pen.createRadialGradient(x - r / 3, y - r / 3, r / 8, x, y, r);
        [[0, 1.35], [.6, 1], [1, .65]].forEach(([at, light]) => shine.addColorStop(at, shaded(item.fill, light)));
        pen.fillStyle = shine; pen.beginPath(); pen.arc(x, y, r, 0, 2 * Math.PI); pen.fill(); return;
      }
      if (item.kind === "line") { path(xy); pen.lineWidth = Math.max(1.2, item.width * s); pen.stroke(); return; }
      path(xy, true); pen.fill();
      // The line closes the gaps between the parts of a face.
      if (pen.globalAlpha === 1) { pen.lineWidth = .7; pen.stroke(); }
      if (!item.body) return;
      pen.strokeStyle = item.edge; pen.lineWidth = 1.1; pen.beginPath();
      item.sides.forEach((edge, i) => { if (edge) { pen.moveTo(xy[i][0], xy[i][1]); const q = xy[(i + 1) % xy.length]; pen.lineTo(q[0], q[1]); } });
      pen.stroke();
    };
    const drawFloor = shadows => {
      pen.globalAlpha = view.tilt < 0 ? .35 : 1;
      pen.strokeStyle = colours.grid; pen.lineWidth = 1;
      grid.forEach(line => { path(line.map(seen)); pen.stroke(); });
      pen.fillStyle = colours.shadow; pen.beginPath();
      shadows.forEach(shadow => { shadow.map(seen).forEach(([x, y], i) => i ? pen.lineTo(x, y) : pen.moveTo(x, y)); pen.closePath(); });
      pen.fill();
    };
    const drawTrails = place => trails.forEach(trail => {
      pen.globalAlpha = lit ? trail.name === lit ? .9 : .08 : .55;
      pen.strokeStyle = trail.colour === "ink" ? colours.ink : trail.colour; pen.lineWidth = 1.3;
      path([...trail.points.slice(0, place[0] + 1), poseAt(trail.group, place)(trail.at)].map(seen)); pen.stroke();
    });
    const draw = place => {
      last = place; aim();
      pen.clearRect(0, 0, wide, tall);
      pen.lineCap = pen.lineJoin = "round"; pen.textAlign = "center"; pen.textBaseline = "middle"; pen.font = "600 13px system-ui, sans-serif";
      const shadows = collect(place);
      if (view.tilt >= 0) drawFloor(shadows);
      if (at("trailing").checked) drawTrails(place);
      items.forEach(item => paint(item, 1));
      // Joints and lines inside bodies show through them.
      items.filter(item => !item.body && item.kind !== "text").forEach(item => paint(item, .2));
      if (view.tilt < 0) drawFloor([]);
      pen.globalAlpha = 1;
    };
    let waiting = false;
    const redraw = () => { if (!waiting) { waiting = true; requestAnimationFrame(() => { waiting = false; draw(last); }); } };

    // Fits the whole motion, seen from the first direction, into the picture.
    const resize = () => {
      const ratio = window.devicePixelRatio || 1;
      [wide, tall] = [canvas.clientWidth || 1, canvas.clientHeight || 1];
      [canvas.width, canvas.height] = [wide, tall].map(x => Math.round(x * ratio));
      pen.setTransform(ratio, 0, 0, ratio, 0, 0);
      const kept = view;
      view = { ...start, move: [0, 0] }; fit = { scale: 1, at: [0, 0] }; aim();
      let [left, top, most, bottom] = [Infinity, Infinity, -Infinity, -Infinity];
      const include = p => { const [x, y] = seen(p); left = Math.min(left, x); most = Math.max(most, x); top = Math.min(top, y); bottom = Math.max(bottom, y); };
      for (let k = 0; k < times.length; k += Math.ceil(times.length / 40)) {
        groups.forEach(group => {
          const move = poseAt(group, frames[k]);
          group.parts.forEach(part => {
            part.faces.forEach(face => face.points.forEach(p => { include(move(p)); if (part.body) include(ground(move(p))); }));
            part.lines.forEach(line => line.points.forEach(p => include(move(p))));
            part.balls.forEach(ball => include(move(ball.at)));
          });
        });
        data.links.forEach(({ ends }) => ends.forEach(([group, ...p]) => include(poseAt(groups[group], frames[k])(p))));
      }
      if (near) frame.forEach(({ tip }) => include(plus(tip, plus(tip, origin, -1), .3)));
      const scale = Math.min((wide - 40) / (most - left || 1), (tall - 56) / (bottom - top || 1));
      // Room for the buttons above.
      fit = { scale, at: [scale * (wide / 2 - (left + most) / 2), scale * (tall / 2 - (top + bottom) / 2) + 12] };
      view = kept; redraw();
    };
    const zoomBy = (factor, [x, y] = [wide / 2, tall / 2]) => {
      const next = Math.min(50, Math.max(.1, view.zoom * factor)), by = next / view.zoom;
      view.move = [by * (view.move[0] + wide / 2 - x) + x - wide / 2, by * (view.move[1] + tall / 2 - y) + y - tall / 2];
      view.zoom = next; redraw();
    };
    const turnBy = (dx, dy) => { view.turn -= dx; view.tilt = Math.min(1.55, Math.max(-1.55, view.tilt + dy)); redraw(); };
    const moveBy = (dx, dy) => { view.move = [view.move[0] + dx, view.move[1] + dy]; redraw(); };
    const reset = () => { view = { ...start, move: [0, 0] }; redraw(); };

    // Names under the pointer.
    const inside = (xy, x, y) => xy.reduce((odd, [x1, y1], i) => {
      const [x0, y0] = xy[(i || xy.length) - 1];
      return (y1 > y) !== (y0 > y) && x < (x0 - x1) * (y - y1) / (y0 - y1) + x1 ? !odd : odd;
    }, false);
    const gap = ([[x0, y0], [x1, y1]], x, y) => {
      const l = (x1 - x0) ** 2 + (y1 - y0) ** 2, t = l > 0 ? Math.min(1, Math.max(0, ((x - x0) * (x1 - x0) + (y - y0) * (y1 - y0)) / l)) : 0;
      return Math.hypot(x - x0 - t * (x1 - x0), y - y0 - t * (y1 - y0));
    };
    const name = (x, y) => {
      const hit = item => item.kind === "face" ? inside(item.xy, x, y) : item.kind === "line" ? gap(item.xy, x, y) < Math.max(5, item.width * item.xy[0][3] / 2)
        : item.kind === "ball" && Math.hypot(x - item.xy[0][0], y - item.xy[0][1]) < Math.max(6, item.radius * item.xy[0][3]);
      const found = items.filter(hit).pop();
      tip.hidden = !found;
      if (!found) return;
      tip.textContent = found.name;
      tip.style.left = Math.max(0, Math.min(x + 12, wide - tip.offsetWidth - 4)) + "px";
      tip.style.top = Math.max(0, y - 30) + "px";
    };
    const pointers = new Map();
    let travelled = 0;
    const place = event => { const box = canvas.getBoundingClientRect(); return [event.clientX - box.left, event.clientY - box.top]; };
    canvas.addEventListener("pointerdown", event => { canvas.setPointerCapture(event.pointerId); pointers.set(event.pointerId, place(event)); travelled = 0; tip.hidden = true; });
    canvas.addEventListener("pointermove", event => {
      const before = pointers.get(event.pointerId), now = place(event);
      if (!before) { name(...now); return; }
      const [dx, dy] = [now[0] - before[0], now[1] - before[1]];
      travelled += Math.hypot(dx, dy);
      const other = [...pointers].find(([id]) => id !== event.pointerId);
      pointers.set(event.pointerId, now);
      if (other) {
        const length = p => Math.max(1, Math.hypot(p[0] - other[1][0], p[1] - other[1][1])), centre = [(now[0] + other[1][0]) / 2, (now[1] + other[1][1]) / 2];
        moveBy(dx / 2, dy / 2); zoomBy(length(now) / length(before), centre);
      } else if (event.shiftKey || event.buttons & 6) moveBy(dx, dy); else turnBy(dx * .008, dy * .008);
    });
    const release = event => { if (pointers.delete(event.pointerId) && travelled < 5 && event.type === "pointerup") name(...place(event)); };
    canvas.addEventListener("pointerup", release);
    canvas.addEventListener("pointercancel", release);
    canvas.addEventListener("pointerleave", event => { if (event.pointerType === "mouse") tip.hidden = true; });
    canvas.addEventListener("contextmenu", event => event.preventDefault());
    canvas.addEventListener("wheel", event => { event.preventDefault(); zoomBy(Math.exp(-Math.max(-80, Math.min(80, event.deltaY)) * .003), place(event)); }, { passive: false });
    canvas.addEventListener("keydown", event => {
      const [dx, dy] = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key] || [0, 0];
      if (dx || dy) { if (event.shiftKey) moveBy(20 * dx, 20 * dy); else turnBy(.1 * dx, .1 * dy); }
      else if (event.key === "+" || event.key === "=") zoomBy(1.2);
      else if (event.key === "-") zoomBy(1 / 1.2);
      else if (event.key === "0" || event.key === "Home") reset();
      else return;
      event.preventDefault();
    });
    at("reset").addEventListener("click", reset);
    at("closer").addEventListener("click", () => zoomBy(1.25));
    at("farther").addEventListener("click", () => zoomBy(1 / 1.25));

    const named = new Map(groups.flatMap(group => group.parts.filter(part => part.body).map(part => [part.name, part.colour])));
    for (const [body, colour] of named) {
      const button = at("legend").appendChild(document.createElement("li")).appendChild(document.createElement("button"));
      button.type = "button"; button.setAttribute("aria-pressed", "false");
      button.appendChild(document.createElement("i")).style.background = colour;
      button.append(body);
      const only = () => [...document.querySelectorAll("#legend button[aria-pressed=true]")].map(button => button.textContent)[0] || null;
      const light = wanted => { lit = wanted; redraw(); };
      button.addEventListener("pointerenter", () => light(body));
      button.addEventListener("pointerleave", () => light(only()));
      button.addEventListener("click", () => {
        const pressed = button.getAttribute("aria-pressed") === "true";
        document.querySelectorAll("#legend button").forEach(other => other.setAttribute("aria-pressed", "false"));
        button.setAttribute("aria-pressed", String(!pressed)); light(only());
      });
    }
    readColours();
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { readColours(); redraw(); });
    window.addEventListener("load", () => { readColours(); resize(); });
    if (window.ResizeObserver) new ResizeObserver(resize).observe(canvas); else window.addEventListener("resize", resize);
    resize();
    return draw;
  })();
