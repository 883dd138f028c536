// Which instruction set the kernels run with on this machine.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace myrialux {

/// Name of the instruction set that kernels are dispatched to now: "SSE4", "AVX2" or "AVX3" (AVX-512).
std::string isa_name();

/// Instruction sets that this machine can run and kernels are compiled for, best first; Highway's bits.
std::vector<std::int64_t> available_isas();
std::string isa_name(std::int64_t isa);

/// Restricts dispatch to one instruction set of available_isas(); 0: choose the best again. For tests and benchmarks;
/// not while kernels run.
void force_isa(std::int64_t isa);

}  // namespace myrialux
