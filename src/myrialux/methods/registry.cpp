// The list of methods that --method knows.
#include "myrialux/base/error.h"
#include "myrialux/methods/render.h"

namespace myrialux {
namespace {

/// Of methods that have no cut a slice.
std::string cannot_choose(const Scene&, const MethodRequest& request) {
  return request.auto_clusters ? "choose the clusters of slices (--clusters auto)" : "";
}

std::string path_cannot(const Scene& scene, const MethodRequest& request) {
  return request.lights_from_file ? "use virtual lights (--lights)" : cannot_choose(scene, request);
}

std::string names_of(const std::vector<MethodInfo>& methods, const std::function<bool(const MethodInfo&)>& wanted) {
  std::string names;
  for (const MethodInfo& m : methods)
    if (wanted(m)) names += (names.empty() ? "" : ", ") + m.name;
  return names;
}

}  // namespace

const std::vector<MethodInfo>& all_methods() {
  static const std::vector<MethodInfo> methods = {
      {.name = "lbamc",
       .summary = "slices, slice lightcut, completion by blocks of 16 neighbouring receivers",
       .source = "ours",
       .render = render_lbamc,
       .keeps_to_error = true},
      {"bamc", "slices, slice lightcut, boolean adaptive matrix completion", "Wang and Holzschuch 2020, section 4",
       render_bamc},
      {"amc", "the same slices and cuts, adaptive matrix completion by pseudo-inverse",
       "Krishnamurthy and Singh 2014; Wang and Holzschuch 2020, section 3.2", render_amc},
      {"gauss-jordan", "the same slices and cuts, adaptive matrix completion by elimination over GF(2)",
       "Wang and Holzschuch 2020, section 5.6", render_gauss_jordan},
      {"matrix-separation",
       "the same slices and cuts, visibility guessed, validated and split into low rank and sparse", "Huo et al. 2015",
       render_matrix_separation},
      {"slice-lightcuts", "the same slices and cuts, every shadow ray traced",
       "Wang and Holzschuch 2020, section 5.3.4", render_slice_lightcuts},
      {"lightcuts", "a cut of the light tree for every receiver, refined to a share of its total", "Walter et al. 2005",
       render_lightcuts, "lightcuts.error", cannot_choose},
      {"lightslice", "slices, columns clustered by a reduced matrix of one traced row a slice, every shadow ray traced",
       "Ou and Pellacini 2011", render_lightslice, "clusters", cannot_choose},
      {"mdlc", "one cut a pixel through the product of its receivers and the lights, 2 % threshold",
       "Walter et al. 2006", render_mdlc, "mdlc.error", cannot_choose, 10000, prepare_mdlc},
      {"illumination-cut", "pairs of point and light clusters within an error bound, one light a pair",
       "Bus, Mustafa and Biri 2015", render_illumination_cut, "illumination-cut.error", cannot_choose},
      {"illumination-cut-sampling", "the same, with the visibility of a pair sampled adaptively",
       "Bus, Mustafa and Biri 2015, algorithm 2", render_illumination_cut_sampling, "illumination-cut-sampling.error",
       cannot_choose},
      {"brute-force", "every receiver, every virtual light, every ray", "-", render_brute_force, "", cannot_choose,
       1000, prepare_brute_force},
      {"path", "path tracer with next-event estimation and multiple importance sampling", "-", {}, "", path_cannot},
  };
  return methods;
}

const MethodInfo& find_method(const std::string& name) {
  for (const MethodInfo& m : all_methods())
    if (m.name == name) return m;
  throw Error(ErrorKind::usage, "unknown method '" + name +
                                    "'; known: " + names_of(all_methods(), [](const MethodInfo&) { return true; }));
}

void require_able(const MethodInfo& method, const Scene& scene, const MethodRequest& request,
                  const std::vector<MethodInfo>& all) {
  const auto fault = [&](const MethodInfo& m) -> std::string {
    if (request.visibility_error && !m.keeps_to_error) return "keep to an error of visibility (--visibility-error)";
    return m.cannot ? m.cannot(scene, request) : std::string();
  };
  const std::string what = fault(method);
  if (what.empty()) return;
  const std::string able = names_of(all, [&](const MethodInfo& m) { return fault(m).empty(); });
  throw Error(ErrorKind::usage, "method '" + method.name + "' cannot " + what +
                                    (able.empty() ? "; no method can" : "; methods that can: " + able));
}

}  // namespace myrialux
