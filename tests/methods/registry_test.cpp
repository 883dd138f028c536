// What methods refuse, and the names of those that can do it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "myrialux/base/error.h"
#include "myrialux/methods/render.h"
#include "support/build_scene.h"

namespace myrialux {
namespace {

std::string refusal(const MethodInfo& method, const Scene& scene, const MethodRequest& request,
                    const std::vector<MethodInfo>& all = all_methods()) {
  try {
    require_able(method, scene, request, all);
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), ErrorKind::usage);
    return e.what();
  }
  return "";
}

TEST(Methods, RefuseWhatTheyCannotDoAndNameThoseThatCan) {
  std::string able;
  for (const MethodInfo& m : all_methods())
    if (m.render) able += (able.empty() ? "" : ", ") + m.name;
  EXPECT_EQ(refusal(find_method("path"), test::cornell_box(), {.lights_from_file = true}),
            "method 'path' cannot use virtual lights (--lights); methods that can: " + able);
  EXPECT_EQ(refusal(find_method("path"), test::cornell_box(), {}), "");
}

TEST(Methods, ChooseClustersWhereSlicesHaveLightCuts) {
  EXPECT_EQ(refusal(find_method("mdlc"), test::cornell_box(), {.auto_clusters = true}),
            "method 'mdlc' cannot choose the clusters of slices (--clusters auto); methods that can: lbamc, bamc, amc, "
            "gauss-jordan, matrix-separation, slice-lightcuts");
}

TEST(Methods, KeepToAnErrorOfVisibilityWhereTheyMeasureIt) {
  EXPECT_EQ(refusal(find_method("bamc"), test::cornell_box(), {.visibility_error = true}),
            "method 'bamc' cannot keep to an error of visibility (--visibility-error); methods that can: lbamc");
  EXPECT_EQ(refusal(find_method("lbamc"), test::cornell_box(), {.auto_clusters = true, .visibility_error = true}), "");
}

TEST(Methods, AllTakeScenesOfToday) {
  for (const MethodInfo& m : all_methods())
    for (const Scene& scene : {test::cornell_box(), test::glass_pane_box(), test::plastic_floor_box()})
      EXPECT_EQ(refusal(m, scene, {}), "") << m.name;
}

TEST(Methods, LookAtTheSceneBeforeTheyRefuse) {
  const auto no_glass = [](const Scene& scene, const MethodRequest&) {
    for (const Material& m : scene.materials)
      if (m.kind == BsdfKind::dielectric || m.kind == BsdfKind::thin_dielectric) return "render glass";
    return "";
  };
  const MethodInfo limited{"limited", "", "", {}, "", no_glass}, other{"other", "", "", {}, "", no_glass},
      general{"general", "", "", {}, "", {}};
  EXPECT_EQ(refusal(limited, test::cornell_box(), {}, {limited, other, general}), "");
  EXPECT_EQ(refusal(limited, test::glass_pane_box(), {}, {limited, other, general}),
            "method 'limited' cannot render glass; methods that can: general");
  EXPECT_EQ(refusal(limited, test::glass_pane_box(), {}, {limited, other}),
            "method 'limited' cannot render glass; no method can");
}

}  // namespace
}  // namespace myrialux
