//! Settings of the allocator.

/// The largest vector after whose end glibc raises the size from which on it
/// maps memory for one vector alone; that is 32 MiB with what it adds.
const LARGEST_RAISING: usize = 31 << 20;

/// Lets the allocator keep memory that is freed for what is made next.
///
/// glibc maps the memory of large vectors for each of them and gives it back to
/// the system when they go, which clears the pages of the next one again: two
/// thirds more page faults on a function of 600,000 operations. It stops when
/// it sees such a vector go. Nothing is written into this one, so it costs
/// nothing; under other allocators it changes nothing.
pub(super) fn keep_freed() {
    drop(std::hint::black_box(Vec::<u8>::with_capacity(
        LARGEST_RAISING,
    )));
}
