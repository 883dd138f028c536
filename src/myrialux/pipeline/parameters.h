// The -D keys: one table gives name, default, meaning and where the value goes.
#pragma once

#include "myrialux/pipeline/pipeline.h"

namespace myrialux {

/// What -D keys may set.
struct TunedParams {
  MethodParams method;
  float sharp_alpha = kDefaultSharpAlpha;
  std::uint32_t direct_samples = 4;  ///< emitter samples a receiver under --direct sampled
};

/// Applies all of RenderParams::extra. @throws Error (usage) for an unknown key (naming the nearest) or a bad value.
void apply_extra(const std::map<std::string, std::string>& extra, TunedParams& params);

/// Every -D key with the value it has in `params`.
std::vector<ParameterInfo> parameter_values(const TunedParams& params);

}  // namespace myrialux
