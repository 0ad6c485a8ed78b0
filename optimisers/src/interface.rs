//! The functions used of IPOPT's C interface (`IpStdCInterface.h` of version 3).

#![expect(unsafe_code, reason = "a library in C++ is called")]

use std::ffi::{c_char, c_int, c_void};

pub type EvalF = unsafe extern "C" fn(c_int, *const f64, c_int, *mut f64, *mut c_void) -> c_int;
pub type EvalG = unsafe extern "C" fn(c_int, *const f64, c_int, c_int, *mut f64, *mut c_void) -> c_int;
pub type EvalJacobian =
    unsafe extern "C" fn(c_int, *const f64, c_int, c_int, c_int, *mut c_int, *mut c_int, *mut f64, *mut c_void) -> c_int;
pub type EvalHessian = unsafe extern "C" fn(
    c_int,
    *const f64,
    c_int,
    f64,
    c_int,
    *const f64,
    c_int,
    c_int,
    *mut c_int,
    *mut c_int,
    *mut f64,
    *mut c_void,
) -> c_int;
pub type Intermediate =
    unsafe extern "C" fn(c_int, c_int, f64, f64, f64, f64, f64, f64, f64, f64, c_int, *mut c_void) -> c_int;

unsafe extern "C" {
    pub fn CreateIpoptProblem(
        n: c_int,
        x_least: *const f64,
        x_most: *const f64,
        m: c_int,
        g_least: *const f64,
        g_most: *const f64,
        of_jacobian: c_int,
        of_hessian: c_int,
        style: c_int,
        f: EvalF,
        g: EvalG,
        gradient: EvalF,
        jacobian: EvalJacobian,
        hessian: EvalHessian,
    ) -> *mut c_void;
    pub fn FreeIpoptProblem(problem: *mut c_void);
    pub fn AddIpoptStrOption(problem: *mut c_void, key: *const c_char, value: *const c_char) -> c_int;
    pub fn AddIpoptNumOption(problem: *mut c_void, key: *const c_char, value: f64) -> c_int;
    pub fn AddIpoptIntOption(problem: *mut c_void, key: *const c_char, value: c_int) -> c_int;
    pub fn SetIntermediateCallback(problem: *mut c_void, callback: Intermediate) -> c_int;
    pub fn IpoptSolve(
        problem: *mut c_void,
        x: *mut f64,
        g: *mut f64,
        value: *mut f64,
        of_g: *mut f64,
        of_least: *mut f64,
        of_most: *mut f64,
        data: *mut c_void,
    ) -> c_int;
}
