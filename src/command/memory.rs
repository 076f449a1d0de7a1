//! Settings of the allocator.

/// The largest vector whose release raises glibc's threshold for mapping memory
/// for one vector alone; the threshold is 32 MiB with the header.
const LARGEST_RAISING: usize = 31 << 20;

/// Makes the allocator keep freed memory for later allocations.
///
/// glibc maps the memory of large vectors for each of them and gives it back to
/// the system when they go, which clears the pages of the next one again: two
/// thirds more page faults on a function of 600,000 operations. It stops when
/// such a vector is freed. This vector is never written, so it costs nothing;
/// other allocators are not affected.
pub(super) fn keep_freed() {
    drop(std::hint::black_box(Vec::<u8>::with_capacity(
        LARGEST_RAISING,
    )));
}
