//! The threads that work while Python goes on.

use std::ptr;
use std::sync::atomic::{AtomicPtr, Ordering};

use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

/// The threads of a process.
struct Pool {
    process: u32,
    pool: ThreadPool,
}

/// Never freed, as other threads may be using it: a pool is replaced only by a process that was
/// forked, which has none of its parent's threads, and where another number is asked for.
static POOL: AtomicPtr<Pool> = AtomicPtr::new(ptr::null_mut());

/// The threads of this process.
fn pool() -> PyResult<&'static ThreadPool> {
    // SAFETY: what is stored there came from a box that was leaked, and nobody changes it.
    let known = unsafe { POOL.load(Ordering::Acquire).as_ref() };
    match known.filter(|pool| pool.process == std::process::id()) {
        Some(pool) => Ok(&pool.pool),
        None => replace(build(0)?),
    }
}

fn replace(pool: ThreadPool) -> PyResult<&'static ThreadPool> {
    let process = std::process::id();
    let pool: &'static Pool = Box::leak(Box::new(Pool { process, pool }));
    POOL.store(ptr::from_ref(pool).cast_mut(), Ordering::Release);
    Ok(&pool.pool)
}

/// So many threads; 0: as many as the machine has, or the variable `RAYON_NUM_THREADS` says.
fn build(n: usize) -> PyResult<ThreadPool> {
    let failed = |error| PyRuntimeError::new_err(format!("threads cannot be started: {error}"));
    ThreadPoolBuilder::new().num_threads(n).build().map_err(failed)
}

fn checked(n: usize) -> PyResult<usize> {
    match n {
        1..=1024 => Ok(n),
        _ => Err(PyValueError::new_err(format!("{n} threads, expected 1 to 1024"))),
    }
}

/// Works on so many threads, or as many as usual, of a pool of its own: long work would keep
/// pictures waiting.
pub(crate) fn beside<R: Send>(
    threads: Option<usize>,
    work: impl FnOnce() -> R + Send,
) -> PyResult<R> {
    let n = threads.map_or_else(num_threads, checked)?;
    Ok(build(n)?.install(work))
}

/// Works on the usual threads while other threads run Python.
pub(crate) fn without_python<R: Send>(
    py: Python<'_>,
    work: impl FnOnce() -> R + Send,
) -> PyResult<R> {
    py.detach(|| Ok(pool()?.install(work)))
}

/// The number of threads that work in this process.
#[pyfunction]
pub(crate) fn num_threads() -> PyResult<usize> {
    Ok(pool()?.current_num_threads())
}

/// Sets the number of threads that work in this process, 1 to 1024.
#[pyfunction]
pub(crate) fn set_num_threads(n: usize) -> PyResult<()> {
    if checked(n)? != pool()?.current_num_threads() {
        replace(build(n)?)?;
    }
    Ok(())
}
