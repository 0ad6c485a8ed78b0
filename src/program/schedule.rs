//! From a graph to a [`Program`]: selection of the operations, their order, and the assignment of registers.
//!
//! A product that is used once, in a sum, is combined with it into one instruction; so are sine and cosine of one angle, and a difference or product
//! of which only the negative is used. Among the operations whose
//! arguments are ready, the most frequent kind is next, so that equal operations form long runs. A register is reused when its number
//! is no longer needed. Stages are scheduled one after the other; later ones use results of earlier ones.

use std::collections::{BTreeMap, HashMap, HashSet, VecDeque};

use super::expression::{Expression, Node};
use super::function::Function;
use super::graph::Graph;
use super::program::{Instruction, Operation, Program, Register, Run};
use super::registers::Registers;

/// Marks a missing register or task.
const NONE: u32 = u32::MAX;

/// A future instruction: an operation on nodes.
struct Task {
    operation: Operation,
    arguments: [Option<Node>; 3],
    /// One node, or sine and cosine.
    results: [Option<Node>; 2],
}

/// The tasks of a program, and the task that computes each node.
struct Tasks {
    list: Vec<Task>,
    maker: Vec<u32>,
}

impl Program {
    /// Compiles programs that compute nodes, stage by stage, from `arguments`, which are the first registers. Each program continues with the results of
    /// earlier ones, and may be run repeatedly. `None` if they need too many registers.
    pub(crate) fn in_stages(graph: &Graph, arguments: &[Node], stages: &[&[Node]]) -> Option<Vec<Self>> {
        let mut is_known = vec![false; graph.len()];
        arguments.iter().for_each(|node| is_known[node.0 as usize] = true);
        let of_all = needed(graph, &is_known, &stages.concat());
        let constant = |&node: &Node| Some((node, graph.value(node).filter(|_| !is_known[node.index()])?));
        let constants: Vec<(Node, f64)> = of_all.iter().filter_map(constant).collect();
        constants.iter().for_each(|(node, _)| is_known[node.0 as usize] = true);
        let mut tasks = Tasks { list: Vec::new(), maker: vec![NONE; graph.len()] };
        let mut plan = Vec::with_capacity(stages.len());
        for results in stages {
            let needed = needed(graph, &is_known, &[results, &*twins(graph, &is_known, results, &of_all)].concat());
            let first = tasks.list.len();
            tasks.add(graph, &is_known, &needed, results);
            let made = tasks.list[first..].iter().flat_map(|task| task.results.iter().flatten());
            made.for_each(|node| is_known[node.0 as usize] = true);
            plan.push((tasks.order(first), *results));
        }
        tasks.assign(&plan, graph.len(), (arguments, constants))
    }
}

/// Sines and cosines that later stages need of angles of which this stage computes the other function.
fn twins(graph: &Graph, is_known: &[bool], results: &[Node], of_all: &[Node]) -> Vec<Node> {
    let angle = |node: &Node| match graph.expression(*node) {
        Expression::Of(Function::Sin | Function::Cos, angle) => Some(angle),
        _ => None,
    };
    let own: HashSet<Node> = needed(graph, is_known, results).iter().filter_map(angle).collect();
    of_all.iter().copied().filter(|node| angle(node).is_some_and(|angle| own.contains(&angle))).collect()
}

/// The nodes required for the results, including the arguments used.
fn needed(graph: &Graph, is_argument: &[bool], results: &[Node]) -> Vec<Node> {
    graph.reachable_through(results.iter().copied(), |node| !is_argument[node.index()])
}

/// Nodes that are combined into one instruction: sines with cosines, negatives with their arguments, and sums with a product.
struct Fusion {
    cosine_of: HashMap<Node, Node>,
    /// Negatives of differences and of products.
    negatives: HashMap<Node, (Operation, [Node; 2])>,
    /// The operation, the factors and the other term of a sum.
    sums: HashMap<Node, (Operation, [Node; 3])>,
    /// The nodes that are part of the instruction of another node.
    absorbed: Vec<bool>,
}

impl Fusion {
    /// Analyses the nodes to be computed, given the number of uses of each node.
    fn new(graph: &Graph, made: &[Node], uses: &[usize]) -> Self {
        let mut fusion = Fusion {
            cosine_of: HashMap::new(),
            negatives: HashMap::new(),
            sums: HashMap::new(),
            absorbed: vec![false; graph.len()],
        };
        let mut is_made = vec![false; graph.len()];
        made.iter().for_each(|node| is_made[node.0 as usize] = true);
        fusion.join_sines(graph, made);
        fusion.join_negatives(graph, made, |node| is_made[node.0 as usize] && uses[node.0 as usize] == 1);
        for &node in made.iter().filter(|node| !fusion.absorbed[node.0 as usize]).collect::<Vec<_>>() {
            let difference = [Operation::MultiplySubtract, Operation::SubtractProduct];
            let (x, y, [with_x, with_y]) = match (graph.expression(node), fusion.negatives.get(&node)) {
                (_, Some(&(Operation::Subtract, [x, y]))) | (Expression::Subtract(x, y), None) => (x, y, difference),
                (Expression::Add(x, y), None) => (x, y, [Operation::MultiplyAdd; 2]),
                _ => continue,
            };
            for (product, other, operation) in [(y, x, with_y), (x, y, with_x)] {
                let k = product.0 as usize;
                if let Expression::Multiply(a, b) = graph.expression(product)
                    && is_made[k]
                    && uses[k] == 1
                {
                    fusion.absorbed[k] = true;
                    fusion.sums.insert(node, (operation, [a, b, other]));
                    break;
                }
            }
        }
        fusion
    }

    fn join_sines(&mut self, graph: &Graph, made: &[Node]) {
        let sine = |node: &Node| match graph.expression(*node) {
            Expression::Of(Function::Sin, angle) => Some((angle, *node)),
            _ => None,
        };
        let sines: HashMap<Node, Node> = made.iter().filter_map(sine).collect();
        for &node in made {
            if let Expression::Of(Function::Cos, angle) = graph.expression(node)
                && let Some(&sine) = sines.get(&angle)
            {
                self.cosine_of.insert(sine, node);
                self.absorbed[node.0 as usize] = true;
            }
        }
    }

    fn join_negatives(&mut self, graph: &Graph, made: &[Node], is_used_once: impl Fn(Node) -> bool) {
        for &node in made {
            let Expression::Of(Function::Negative, of) = graph.expression(node) else { continue };
            let joined = match graph.expression(of) {
                // −(x − y) and y − x differ in the sign of a zero.
                Expression::Subtract(x, y) if !graph.is_signed(node) => (Operation::Subtract, [y, x]),
                Expression::Multiply(x, y) => (Operation::NegativeProduct, [x, y]),
                _ => continue,
            };
            if is_used_once(of) {
                self.absorbed[of.0 as usize] = true;
                self.negatives.insert(node, joined);
            }
        }
    }

    /// The task that computes a node.
    fn task(&self, graph: &Graph, node: Node) -> Task {
        let mut of = graph.expression(node).arguments();
        let arguments = [of.next(), of.next(), None];
        let results = [Some(node), self.cosine_of.get(&node).copied()];
        if let Some(&(operation, of)) = self.sums.get(&node) {
            Task { operation, arguments: of.map(Some), results }
        } else if let Some(&(operation, [x, y])) = self.negatives.get(&node) {
            Task { operation, arguments: [Some(x), Some(y), None], results }
        } else {
            let is_pair = results[1].is_some();
            let operation = if is_pair { Operation::SinCos } else { Operation::of(graph.expression(node)) };
            Task { operation, arguments, results }
        }
    }
}

impl Tasks {
    /// Adds the tasks of a stage for needed nodes that are not known.
    fn add(&mut self, graph: &Graph, is_known: &[bool], needed: &[Node], results: &[Node]) {
        let is_made = |node: &Node| !is_known[node.0 as usize];
        let made: Vec<Node> = needed.iter().copied().filter(is_made).collect();
        let mut uses = vec![0; graph.len()];
        let used = made.iter().flat_map(|&node| graph.expression(node).arguments());
        used.chain(results.iter().copied()).for_each(|node| uses[node.0 as usize] += 1);
        let fusion = Fusion::new(graph, &made, &uses);
        for &node in made.iter().filter(|node| !fusion.absorbed[node.0 as usize]) {
            let task = fusion.task(graph, node);
            for result in task.results.iter().flatten() {
                self.maker[result.0 as usize] = self.list.len() as u32;
            }
            self.list.push(task);
        }
    }

    /// An order of the tasks of the last stage, from `first` on: arguments come first, and equal operations are adjacent.
    fn order(&self, first: usize) -> Vec<usize> {
        let mut waiting = vec![0; self.list.len()];
        let mut users = vec![Vec::new(); self.list.len()];
        for (k, task) in self.list.iter().enumerate().skip(first) {
            for argument in task.arguments.iter().flatten() {
                let maker = self.maker[argument.0 as usize];
                if maker != NONE && maker as usize >= first {
                    waiting[k] += 1;
                    users[maker as usize].push(k);
                }
            }
        }
        let mut ready: BTreeMap<Operation, VecDeque<usize>> = BTreeMap::new();
        for (k, task) in self.list.iter().enumerate().skip(first).filter(|(k, _)| waiting[*k] == 0) {
            ready.entry(task.operation).or_default().push_back(k);
        }
        let mut order = Vec::with_capacity(self.list.len() - first);
        while let Some(operation) = ready.iter().max_by_key(|(_, tasks)| tasks.len()).map(|(operation, _)| *operation) {
            let mut run = ready.remove(&operation).unwrap_or_default();
            // The task that has waited longest is next, because its arguments were computed earlier and are available.
            while let Some(k) = run.pop_front() {
                order.push(k);
                for &user in &users[k] {
                    waiting[user] -= 1;
                    if waiting[user] == 0 {
                        let kind = self.list[user].operation;
                        let queue = if kind == operation { &mut run } else { ready.entry(kind).or_default() };
                        queue.push_back(user);
                    }
                }
            }
        }
        order
    }

    /// Assigns a register to every node: first arguments, then constants, then results. Results that later stages need are kept.
    fn assign(
        &self,
        plan: &[(Vec<usize>, &[Node])],
        nodes: usize,
        (arguments, constants): (&[Node], Vec<(Node, f64)>),
    ) -> Option<Vec<Program>> {
        let mut registers = Registers::new(nodes, arguments.iter().copied().chain(constants.iter().map(|(node, _)| *node)));
        for (order, results) in plan {
            let used = order.iter().flat_map(|&k| self.list[k].arguments.iter().flatten());
            used.chain(*results).for_each(|node| registers.uses[node.0 as usize] += 1);
        }
        let constants: Vec<f64> = constants.into_iter().map(|(_, value)| value).collect();
        let mut programs = Vec::with_capacity(plan.len());
        for (order, results) in plan {
            let mut program = Program { arguments: arguments.len(), constants: constants.clone(), ..Program::default() };
            for &k in order {
                let Task { operation, arguments, results } = &self.list[k];
                program.push(*operation, registers.take(*operation, arguments, results));
            }
            program.results = results.iter().map(|node| registers.of[node.0 as usize] as Register).collect();
            results.iter().for_each(|node| registers.uses[node.0 as usize] -= 1);
            registers.keep();
            programs.push(program);
        }
        Register::try_from(registers.next).ok()?;
        programs.iter_mut().for_each(|program| program.registers = registers.next as usize);
        Some(programs)
    }
}

impl Program {
    fn push(&mut self, operation: Operation, instruction: Instruction) {
        self.instructions.push(instruction);
        match self.runs.last_mut() {
            Some(run) if run.operation == operation => run.count += 1,
            _ => self.runs.push(Run { operation, count: 1 }),
        }
    }
}
