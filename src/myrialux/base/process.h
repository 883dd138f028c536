// What this process may use and does use of its machine: threads of parallel loops, memory.
#pragma once

#include <cstdint>

namespace myrialux {

/// Threads that parallel loops use now at most: as ThreadScope says, but no more than there are processors.
int allowed_threads();

/// Bytes of memory this process holds now. 0 if the system does not tell.
std::uint64_t resident_bytes();

/// Gives memory that was freed back to the system, so that resident_bytes() counts only what is in use.
void release_freed_memory();

}  // namespace myrialux
