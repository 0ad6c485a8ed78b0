//! [`Program`]: a formula as a list of instructions without branches, executed for several elements side by side.

use std::fmt;

use super::expression::Expression;
use super::function::Function;
use crate::number::{exp_lanes, sin_cos_lanes};

/// The operation of an instruction on its arguments x, y, z.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Operation {
    Add,
    Subtract,
    Multiply,
    Divide,
    /// x y + z
    MultiplyAdd,
    /// x y − z
    MultiplySubtract,
    /// z − x y
    SubtractProduct,
    /// −x y
    NegativeProduct,
    /// Sine and cosine, written to two registers.
    SinCos,
    IntegerPower(i32),
    Power,
    Atan2,
    Max,
    Min,
    Less,
    Where,
    Vanishing,
    Of(Function),
}

impl Operation {
    pub(super) fn of(expression: Expression) -> Self {
        match expression {
            Expression::Add(..) => Operation::Add,
            Expression::Subtract(..) => Operation::Subtract,
            Expression::Multiply(..) => Operation::Multiply,
            Expression::Divide(..) => Operation::Divide,
            Expression::IntegerPower(_, n) => Operation::IntegerPower(n),
            Expression::Power(..) | Expression::SlopePower(..) => Operation::Power,
            Expression::Atan2(..) => Operation::Atan2,
            Expression::Max(..) => Operation::Max,
            Expression::Min(..) => Operation::Min,
            Expression::Less(..) => Operation::Less,
            Expression::Where(..) => Operation::Where,
            Expression::Vanishing(..) => Operation::Vanishing,
            Expression::Of(function, _) => Operation::Of(function),
            Expression::Constant(_) | Expression::Parameter(_) | Expression::Input(_) => {
                unreachable!("constants and arguments are not computed")
            }
        }
    }
}

/// A register.
pub(super) type Register = u16;

/// The registers that an instruction reads, and the one it writes; a cosine is written to the second of the former.
#[derive(Clone, Copy, Debug)]
pub(super) struct Instruction {
    pub(super) of: [Register; 3],
    pub(super) into: Register,
}

/// Consecutive instructions of one kind.
#[derive(Clone, Debug)]
pub(super) struct Run {
    pub(super) operation: Operation,
    pub(super) count: usize,
}

/// A list of instructions on registers: first the arguments, then constants, then results of instructions.
#[derive(Clone, Debug, Default)]
pub(crate) struct Program {
    pub(super) arguments: usize,
    pub(super) constants: Vec<f64>,
    pub(super) instructions: Vec<Instruction>,
    pub(super) runs: Vec<Run>,
    pub(super) registers: usize,
    pub(super) results: Vec<Register>,
}

impl Program {
    /// The number of arguments, which are the first registers.
    pub(crate) fn arguments(&self) -> usize {
        self.arguments
    }

    /// The values of the registers after the arguments, which are constant.
    pub(crate) fn constants(&self) -> &[f64] {
        &self.constants
    }

    /// The number of registers, for each element.
    pub(crate) fn registers(&self) -> usize {
        self.registers
    }

    /// The registers of the results.
    pub(crate) fn results(&self) -> impl ExactSizeIterator<Item = usize> {
        self.results.iter().map(|&register| usize::from(register))
    }

    /// The number of instructions.
    pub(crate) fn len(&self) -> usize {
        self.instructions.len()
    }

    /// Computes the results of `L` elements side by side.
    pub(crate) fn run<const L: usize>(&self, registers: &mut [[f64; L]]) {
        let mut rest = &self.instructions[..];
        for Run { operation, count } in &self.runs {
            let instructions;
            (instructions, rest) = rest.split_at(*count);
            match *operation {
                Operation::Add => binary(instructions, registers, |x, y| x + y),
                Operation::Subtract => binary(instructions, registers, |x, y| x - y),
                Operation::Multiply => binary(instructions, registers, |x, y| x * y),
                Operation::Divide => binary(instructions, registers, |x, y| x / y),
                Operation::MultiplyAdd => ternary(instructions, registers, |x, y, z| x * y + z),
                Operation::MultiplySubtract => ternary(instructions, registers, |x, y, z| x * y - z),
                Operation::SubtractProduct => ternary(instructions, registers, |x, y, z| z - x * y),
                Operation::NegativeProduct => binary(instructions, registers, |x, y| -(x * y)),
                Operation::SinCos => sin_cos(instructions, registers),
                Operation::IntegerPower(n) => unary(instructions, registers, |x| x.powi(n)),
                Operation::Power => binary(instructions, registers, f64::powf),
                Operation::Atan2 => binary(instructions, registers, f64::atan2),
                Operation::Max => binary(instructions, registers, |x, y| if y > x { y } else { x }),
                Operation::Min => binary(instructions, registers, |x, y| if y < x { y } else { x }),
                Operation::Less => binary(instructions, registers, |x, y| f64::from(x < y)),
                Operation::Where => binary(instructions, registers, |condition, x| if condition == 0.0 { 0.0 } else { x }),
                Operation::Vanishing => binary(instructions, registers, |x, y| if y == 0.0 { 0.0 } else { x * y }),
                Operation::Of(Function::Sin) => lanes(instructions, registers, |x| sin_cos_lanes(x).0),
                Operation::Of(Function::Cos) => lanes(instructions, registers, |x| sin_cos_lanes(x).1),
                Operation::Of(Function::Exp) => lanes(instructions, registers, exp_lanes),
                Operation::Of(Function::Negative) => unary(instructions, registers, |x| -x),
                Operation::Of(Function::Reciprocal) => unary(instructions, registers, f64::recip),
                Operation::Of(Function::Sqrt) => unary(instructions, registers, f64::sqrt),
                Operation::Of(function) => unary(instructions, registers, |x| function.value(x)),
            }
        }
    }
}

/// Executes instructions with one argument.
#[inline(always)]
fn unary<const L: usize>(instructions: &[Instruction], registers: &mut [[f64; L]], f: impl Fn(f64) -> f64) {
    lanes(instructions, registers, |x| x.map(&f));
}

/// Executes instructions with one argument, all lanes at once.
#[inline(always)]
fn lanes<const L: usize>(instructions: &[Instruction], registers: &mut [[f64; L]], f: impl Fn(&[f64; L]) -> [f64; L]) {
    for Instruction { of, into } in instructions {
        registers[usize::from(*into)] = f(&registers[usize::from(of[0])]);
    }
}

/// Executes instructions with two arguments.
#[inline(always)]
fn binary<const L: usize>(instructions: &[Instruction], registers: &mut [[f64; L]], f: impl Fn(f64, f64) -> f64) {
    for Instruction { of, into } in instructions {
        let (x, y) = (registers[usize::from(of[0])], registers[usize::from(of[1])]);
        registers[usize::from(*into)] = std::array::from_fn(|lane| f(x[lane], y[lane]));
    }
}

/// Executes instructions with three arguments.
#[inline(always)]
fn ternary<const L: usize>(instructions: &[Instruction], registers: &mut [[f64; L]], f: impl Fn(f64, f64, f64) -> f64) {
    for Instruction { of, into } in instructions {
        let [x, y, z] = of.map(|register| registers[usize::from(register)]);
        registers[usize::from(*into)] = std::array::from_fn(|lane| f(x[lane], y[lane], z[lane]));
    }
}

/// Executes instructions that compute sine and cosine.
fn sin_cos<const L: usize>(instructions: &[Instruction], registers: &mut [[f64; L]]) {
    for Instruction { of, into } in instructions {
        let (sin, cos) = sin_cos_lanes(&registers[usize::from(of[0])]);
        registers[usize::from(*into)] = sin;
        registers[usize::from(of[1])] = cos;
    }
}

impl Instruction {
    fn write(&self, f: &mut fmt::Formatter, operation: Operation) -> fmt::Result {
        let ([x, y, z], into) = (self.of, self.into);
        match operation {
            Operation::Add => write!(f, "r{into} = r{x} + r{y}"),
            Operation::Subtract => write!(f, "r{into} = r{x} - r{y}"),
            Operation::Multiply => write!(f, "r{into} = r{x} * r{y}"),
            Operation::Divide => write!(f, "r{into} = r{x} / r{y}"),
            Operation::MultiplyAdd => write!(f, "r{into} = r{x} * r{y} + r{z}"),
            Operation::MultiplySubtract => write!(f, "r{into} = r{x} * r{y} - r{z}"),
            Operation::SubtractProduct => write!(f, "r{into} = r{z} - r{x} * r{y}"),
            Operation::NegativeProduct => write!(f, "r{into} = -r{x} * r{y}"),
            Operation::SinCos => write!(f, "r{into}, r{y} = sin r{x}, cos r{x}"),
            Operation::IntegerPower(n) => write!(f, "r{into} = r{x} ^ {n}"),
            Operation::Power => write!(f, "r{into} = r{x} ^ r{y}"),
            Operation::Atan2 => write!(f, "r{into} = atan2 r{x}, r{y}"),
            Operation::Max => write!(f, "r{into} = max r{x}, r{y}"),
            Operation::Min => write!(f, "r{into} = min r{x}, r{y}"),
            Operation::Less => write!(f, "r{into} = r{x} < r{y}"),
            Operation::Where => write!(f, "r{into} = r{y} where r{x}"),
            Operation::Vanishing => write!(f, "r{into} = r{x} * r{y} where r{y}"),
            Operation::Of(Function::Negative) => write!(f, "r{into} = -r{x}"),
            Operation::Of(Function::Reciprocal) => write!(f, "r{into} = 1/r{x}"),
            Operation::Of(function) => write!(f, "r{into} = {} r{x}", function.name()),
        }
    }
}

impl fmt::Display for Program {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        for (k, value) in self.constants.iter().enumerate() {
            writeln!(f, "r{} = {value:?}", self.arguments + k)?;
        }
        let operations = self.runs.iter().flat_map(|run| std::iter::repeat_n(run.operation, run.count));
        for (operation, instruction) in operations.zip(&self.instructions) {
            instruction.write(f, operation)?;
            writeln!(f)?;
        }
        Ok(())
    }
}
