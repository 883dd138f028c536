// Instruction sets the kernels are compiled for: SSE4.2 (the baseline), AVX2, AVX-512. Include before hwy/highway.h.
// Kernels that must give the same bits everywhere use Mul and Add, not MulAdd: SSE4.2 has no fused form.
#pragma once

#define HWY_DISABLE_PCLMUL_AES  // else plain x86-64-v2 would count as SSSE3
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_AVX3_DL)
