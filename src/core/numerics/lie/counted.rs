//! Counts products of packs, to find the cost of a sweep.

use std::cell::Cell;

thread_local! {
    static PRODUCTS: Cell<u64> = const { Cell::new(0) };
}

/// Number of products of packs during `sweep`. A multiply-add counts as one; sums are free, as on a machine with fused
/// multiply-adds.
pub(crate) fn products<R>(sweep: impl FnOnce() -> R) -> u64 {
    let before = PRODUCTS.get();
    sweep();
    PRODUCTS.get() - before
}

/// Adds one.
#[inline(always)]
pub(super) fn count_product() {
    PRODUCTS.set(PRODUCTS.get() + 1);
}
