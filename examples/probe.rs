use hamiltonian_adjoint::{Grid, Inputs, Settings, Solver, scenes::CartPendulum};
fn main() {
    let k: usize = std::env::args().nth(1).unwrap().parse().unwrap();
    let system = CartPendulum::with_links(k).scene().compile().unwrap();
    let n: usize = std::env::args().nth(2).unwrap().parse().unwrap();
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(n, 0.01));
    inputs.controls.fill(10.0);
    let mut solver = Solver::new(&system, Settings::default());
    for _ in 0..3 {
        println!("{:?}", solver.simulate(&inputs).err());
        println!("{:?}", solver.report());
    }
    let t = solver.trajectory();
    println!("{:e} {:e}", t.v.amax(), t.sigma.amax());
}
