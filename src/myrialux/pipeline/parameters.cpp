// The -D keys: parsing, ranges and defaults in one table.
#include "myrialux/pipeline/parameters.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <functional>

#include "myrialux/base/suggest.h"

namespace myrialux {
namespace {

struct Key {
  std::string name, meaning;
  std::function<std::string(const TunedParams&)> get;
  std::function<void(TunedParams&, const std::string& text)> set;
};

[[noreturn]] void refuse(const std::string& key, const std::string& text, const std::string& allowed) {
  throw Error(ErrorKind::usage, fmt::format("-D {}={}: allowed is {}", key, text, allowed));
}

/// @param member picks the float that the key sets; [low, high] is what it may be
Key number_key(const std::string& name, float low, float high, std::string meaning,
               const std::function<float&(TunedParams&)>& member) {
  const auto set = [=](TunedParams& p, const std::string& text) {
    float value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || !(value >= low && value <= high))
      refuse(name, text, fmt::format("a number from {} to {}", low, high));
    member(p) = value;
  };
  const auto get = [=](const TunedParams& p) { return fmt::format("{}", member(const_cast<TunedParams&>(p))); };
  return {name, std::move(meaning), get, set};
}

Key count_key(const std::string& name, std::uint32_t low, std::uint32_t high, std::string meaning,
              const std::function<std::uint32_t&(TunedParams&)>& member) {
  const auto set = [=](TunedParams& p, const std::string& text) {
    std::uint32_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || value < low || value > high)
      refuse(name, text, fmt::format("a whole number from {} to {}", low, high));
    member(p) = value;
  };
  const auto get = [=](const TunedParams& p) { return std::to_string(member(const_cast<TunedParams&>(p))); };
  return {name, std::move(meaning), get, set};
}

Key switch_key(const std::string& name, std::string meaning, const std::function<bool&(TunedParams&)>& member) {
  const auto set = [=](TunedParams& p, const std::string& text) {
    if (text != "true" && text != "false") refuse(name, text, "true or false");
    member(p) = text == "true";
  };
  const auto get = [=](const TunedParams& p) {
    return member(const_cast<TunedParams&>(p)) ? std::string("true") : std::string("false");
  };
  return {name, std::move(meaning), get, set};
}

/// @param names what may be given, in the order of the values of the enumeration
template <class Enum>
Key choice_key(const std::string& name, const std::vector<std::string>& names, std::string meaning,
               const std::function<Enum&(TunedParams&)>& member) {
  const auto set = [=](TunedParams& p, const std::string& text) {
    const auto it = std::find(names.begin(), names.end(), text);
    if (it == names.end()) refuse(name, text, fmt::format("{}", fmt::join(names, " or ")));
    member(p) = static_cast<Enum>(it - names.begin());
  };
  const auto get = [=](const TunedParams& p) {
    return names[static_cast<std::size_t>(member(const_cast<TunedParams&>(p)))];
  };
  return {name, std::move(meaning), get, set};
}

/// What the completions by columns share: [wang20, 4.5].
void add_rate_keys(std::vector<Key>& table, const std::string& method, RowRates& (*rates)(TunedParams&)) {
  using P = TunedParams;
  table.push_back(number_key(
      method + ".alpha", 0, 1,
      "share of a column's rows sampled at first", [=](P & p) -> auto& { return rates(p).alpha; }));
  table.push_back(number_key(
      method + ".beta", 0, 1,
      "share verified; added to alpha when a column fails", [=](P & p) -> auto& { return rates(p).beta; }));
  table.push_back(number_key(
      method + ".omega", 0, 1, "largest alpha", [=](P & p) -> auto& { return rates(p).omega; }));
  table.push_back(switch_key(
      method + ".importance", "sample rows where earlier columns changed; false: uniformly", [=](P & p) -> auto& {
        return rates(p).importance;
      }));
  table.push_back(switch_key(
      method + ".adaptive",
      "raise alpha after a failed verification; false: keep it", [=](P & p) -> auto& { return rates(p).adaptive; }));
  table.push_back(switch_key(
      method + ".resample", "draw rows for each column; false: after a column traced whole", [=](P & p) -> auto& {
        return rates(p).resample;
      }));
}

/// What all completions share.
void add_entry_keys(std::vector<Key>& table, const std::string& method, bool& (*cull)(MethodParams&),
                    float& (*guard)(MethodParams&)) {
  using P = TunedParams;
  table.push_back(switch_key(
      method + ".cull",
      "leave out entries whose transfer is zero; false: trace them too, as published", [=](P & p) -> auto& {
        return cull(p.method);
      }));
  table.push_back(number_key(
      method + ".guard", 0, 1e30f,
      "entries above this many times the picture's mean are always traced; 0: as published", [=](P & p) -> auto& {
        return guard(p.method);
      }));
}

void add_separation_keys(std::vector<Key>& table) {
  using P = TunedParams;
  table.push_back(number_key(
      "separation.samples", 0, 1, "share of a column's rows traced at first and in each round",
      [](P & p) -> auto& { return p.method.separation.samples; }));
  table.push_back(number_key(
      "separation.error", 0, 1, "share of a round's samples that the best guess may miss",
      [](P & p) -> auto& { return p.method.separation.error; }));
  table.push_back(count_key(
      "separation.rounds", 0, 1000, "rounds of prediction and validation at most",
      [](P & p) -> auto& { return p.method.separation.rounds; }));
  table.push_back(number_key(
      "separation.energy", 0, 1e30f, "columns below this many times the mean column's energy are not validated",
      [](P & p) -> auto& { return p.method.separation.energy; }));
  table.push_back(switch_key(
      "separation.separate", "split guesses into low rank and errors; false: take them as they are",
      [](P & p) -> auto& { return p.method.separation.separate; }));
  table.push_back(number_key(
      "separation.lambda", 1e-6f, 1e6f, "price of a wrong guess, times 1 / sqrt(rows)",
      [](P & p) -> auto& { return p.method.separation.lambda; }));
  table.push_back(count_key(
      "separation.iterations", 1, 10000, "of the separation at most",
      [](P & p) -> auto& { return p.method.separation.iterations; }));
}

void add_localized_keys(std::vector<Key>& table) {
  using P = TunedParams;
  table.push_back(count_key(
      "lbamc.first_samples", 1, 65536, "rows of a column traced first, spread over its blocks",
      [](P & p) -> auto& { return p.method.lbamc.first_samples; }));
  table.push_back(count_key(
      "lbamc.samples", 1, 65536, "rows of a column traced in all where the first do not settle it",
      [](P & p) -> auto& { return p.method.lbamc.samples; }));
  table.push_back(number_key(
      "lbamc.watch", 0, 1e30f, "blocks above this many times the picture's mean get a sample of their own",
      [](P & p) -> auto& { return p.method.lbamc.watch; }));
  table.push_back(number_key(
      "lbamc.settle", 0, 1e30f, "the same in columns that the first samples settle",
      [](P & p) -> auto& { return p.method.lbamc.settle; }));
  table.push_back(number_key(
      "lbamc.guard", 0, 1e30f, "blocks above this many times the picture's mean are traced",
      [](P & p) -> auto& { return p.method.lbamc.guard; }));
  table.push_back(count_key(
      "lbamc.few", 0, 65536, "columns of no more active rows are traced whole",
      [](P & p) -> auto& { return p.method.lbamc.few; }));
  table.push_back(count_key(
      "lbamc.memory", 1, 65536, "completed columns that a column is compared with",
      [](P & p) -> auto& { return p.method.lbamc.memory; }));
  table.push_back(count_key(
      "lbamc.flood", 0, 64, "nearest blocks traced besides one that is not as predicted",
      [](P & p) -> auto& { return p.method.lbamc.flood; }));
  table.push_back(number_key(
      "lbamc.copy_mixed", 0, 1e30f, "partly visible blocks below this many times the picture's mean are copied",
      [](P & p) -> auto& { return p.method.lbamc.copy_mixed; }));
  table.push_back(number_key(
      "lbamc.risk", 0, 1e30f, "blocks are traced, not copied, where energy squared times doubt is larger",
      [](P & p) -> auto& { return p.method.lbamc.risk; }));
  table.push_back(number_key(
      "lbamc.whole", 0, 1e30f, "doubtful blocks below this energy are traced in one row of four",
      [](P & p) -> auto& { return p.method.lbamc.whole; }));
}

void add_completion_keys(std::vector<Key>& table) {
  using M = MethodParams;
  add_localized_keys(table);
  add_rate_keys(
      table, "bamc", [](TunedParams & p) -> auto& { return p.method.bamc; });
  add_entry_keys(
      table, "bamc", [](M & p) -> auto& { return p.bamc_cull; }, [](M & p) -> auto& { return p.bamc_guard; });
  add_rate_keys(
      table, "amc", [](TunedParams & p) -> auto& { return p.method.amc.rows; });
  table.push_back(number_key(
      "amc.tolerance", 0, 1e6f, "largest sum of squared residuals of the samples",
      [](TunedParams & p) -> auto& { return p.method.amc.tolerance; }));
  add_entry_keys(
      table, "amc", [](M & p) -> auto& { return p.amc_cull; }, [](M & p) -> auto& { return p.amc_guard; });
  add_rate_keys(
      table, "gauss-jordan", [](TunedParams & p) -> auto& { return p.method.gauss_jordan; });
  add_entry_keys(
      table, "gauss-jordan", [](M & p) -> auto& { return p.gauss_jordan_cull; },
      [](M & p) -> auto& { return p.gauss_jordan_guard; });
  add_separation_keys(table);
  add_entry_keys(
      table, "separation", [](M & p) -> auto& { return p.separation_cull; },
      [](M & p) -> auto& { return p.separation_guard; });
}

std::vector<Key> other_keys() {
  using P = TunedParams;
  return {
      count_key(
          "slices.rows", 16, 65536, "receivers a slice at most",
          [](P & p) -> auto& { return p.method.slices.max_rows; }),
      number_key(
          "slices.normal_weight", 0, 100, "weight of normals in slices and light tree, times the scene radius",
          [](P & p) -> auto& { return p.method.slices.normal_weight; }),
      count_key(
          "cut.points", 0, 65536, "receivers of a slice at which cluster errors are bounded; 0 = all",
          [](P & p) -> auto& { return p.method.cut.n_points; }),
      number_key(
          "lightcuts.error", 0, 1, "largest error bound of a cluster over the receiver's total",
          [](P & p) -> auto& { return p.method.lightcuts.error; }),
      choice_key<TreeKind>(
          "lightcuts.tree", {"agglomerative", "divisive"}, "how the light tree is built: agglomerative or divisive",
          [](P & p) -> auto& { return p.method.lightcuts.tree; }),
      switch_key(
          "lightcuts.together", "refine 16 neighbouring receivers in one order; false: each alone, as published",
          [](P & p) -> auto& { return p.method.lightcuts.together; }),
      number_key(
          "mdlc.error", 0, 1, "largest error bound of a pair of clusters, as a share of the pixel's estimate",
          [](P & p) -> auto& { return p.method.mdlc_error; }),
      number_key(
          "illumination-cut.error", 0, 1, "largest error bound of a pair, as a share of the approximate radiance",
          [](P & p) -> auto& { return p.method.illumination_cut.error; }),
      number_key(
          "illumination-cut.radius", 0.001f, 1, "phase I: largest radius of a pair's clusters over their distance",
          [](P & p) -> auto& { return p.method.illumination_cut.approximation.radius; }),
      number_key(
          "illumination-cut.aperture", 0.1f, 360, "phase I: largest opening angle of light cones, degrees",
          [](P & p) -> auto& { return p.method.illumination_cut.approximation.aperture_deg; }),
      count_key(
          "illumination-cut.normal_levels", 0, kMaxNormalLevels, "levels of the point tree that divide normals",
          [](P & p) -> auto& { return p.method.illumination_cut.normal_levels; }),
      choice_key<TreeKind>(
          "illumination-cut.tree", {"agglomerative", "divisive"}, "as lightcuts.tree",
          [](P & p) -> auto& { return p.method.illumination_cut.tree; }),
      number_key(
          "illumination-cut-sampling.error", 0, 1, "as illumination-cut.error",
          [](P & p) -> auto& { return p.method.illumination_cut.sampling_error; }),
      count_key(
          "illumination-cut-sampling.samples", 2, kMaxPairSamples, "rays a pair of more than `large` receivers",
          [](P & p) -> auto& { return p.method.illumination_cut.sampling.samples; }),
      count_key(
          "illumination-cut-sampling.few_samples", 2, kMaxPairSamples, "rays a pair of fewer",
          [](P & p) -> auto& { return p.method.illumination_cut.sampling.few_samples; }),
      count_key(
          "illumination-cut-sampling.large", 1, 1 << 20, "see above",
          [](P & p) -> auto& { return p.method.illumination_cut.sampling.large; }),
      count_key(
          "illumination-cut-sampling.least", 2, kMaxLeastPoints, "pairs of fewer receivers are traced whole",
          [](P & p) -> auto& { return p.method.illumination_cut.sampling.least; }),
      count_key(
          "lightslice.slices", 1, 1000000,
          "slices, and rows of the reduced matrix, at most (64 receivers each at least)",
          [](P & p) -> auto& { return p.method.lightslice.n_slices; }),
      count_key(
          "lightslice.neighbours", 1, 8, "nearest slices, itself included, whose rows refine a slice's clusters",
          [](P & p) -> auto& { return p.method.lightslice.n_neighbours; }),
      number_key(
          "lightslice.global", 0, 1, "global clusters, share of --clusters",
          [](P & p) -> auto& { return p.method.lightslice.global_share; }),
      count_key(
          "lightslice.dimensions", 1, 65536, "dimensions that columns are projected to for the global clusters",
          [](P & p) -> auto& { return p.method.lightslice.n_dimensions; }),
      number_key(
          "lightslice.local", 0, 1,
          "share of representatives drawn by norms in the neighbourhood, else over all slices",
          [](P & p) -> auto& { return p.method.lightslice.local_share; }),
      number_key(
          "lightslice.power", 0, 1, "share of representatives drawn by power, whoever sees them; 0: as published",
          [](P & p) -> auto& { return p.method.lightslice.power_share; }),
      count_key(
          "direct.samples", 1, 4096, "emitter samples a receiver where direct light is sampled",
          [](P & p) -> auto& { return p.direct_samples; }),
      number_key(
          "sharp_alpha", 0, 1, "roughness below which gloss is followed by rays instead of joined to lights",
          [](P & p) -> auto& { return p.sharp_alpha; }),
  };
}

const std::vector<Key>& keys() {
  static const std::vector<Key> table = [] {
    std::vector<Key> all = other_keys();
    add_completion_keys(all);
    return all;
  }();
  return table;
}

}  // namespace

void apply_extra(const std::map<std::string, std::string>& extra, TunedParams& params) {
  for (const auto& [name, text] : extra) {
    const auto it = std::find_if(keys().begin(), keys().end(), [&key = name](const Key& k) { return k.name == key; });
    if (it == keys().end()) {
      std::vector<std::string> names;
      for (const Key& k : keys()) names.push_back(k.name);
      throw Error(ErrorKind::usage, fmt::format("-D {}: no such key{}", name, did_you_mean(name, names)));
    }
    it->set(params, text);
  }
  params.method.tree.normal_weight = params.method.slices.normal_weight;
}

std::vector<ParameterInfo> parameter_values(const TunedParams& params) {
  std::vector<ParameterInfo> values;
  for (const Key& k : keys()) values.push_back({k.name, k.get(params), k.meaning});
  return values;
}

std::vector<ParameterInfo> parameter_table() { return parameter_values({}); }

}  // namespace myrialux
