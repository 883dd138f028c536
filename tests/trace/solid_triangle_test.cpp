// The triangle that a ray meets first, if it is one that always blocks.
#include <gtest/gtest.h>

#include <utility>

#include "myrialux/trace/tracer.h"
#include "support/build_scene.h"

namespace myrialux {
namespace {

/// A square at z = 0 of some material, and a solid one below.
Scene square_above(BsdfKind kind, float opacity) {
  test::SceneBuilder b;
  const MaterialId white = b.diffuse({0.5f, 0.5f, 0.5f});
  Material m;
  m.name = "above";
  m.kind = kind;
  m.opacity = {gray(opacity)};
  b.rectangle({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, b.add(m));
  b.rectangle({-1, -1, -1}, {2, 0, 0}, {0, 2, 0}, white);
  b.camera({0, 0, 3}, {0, 0, 0}, 40, 8, 8);
  return std::move(b.scene);
}

const Ray kDown{{0.3f, 0.2f, 2}, {0, 0, -1}};

TEST(SolidTriangle, IsTheFirstOfAMesh) {
  const Scene scene = square_above(BsdfKind::diffuse, 1);
  const Tracer tracer(scene);
  const auto corners = tracer.solid_triangle(kDown);
  ASSERT_TRUE(corners.has_value());
  for (const Vec3 corner : *corners) {
    EXPECT_EQ(corner.z, 0);
    EXPECT_EQ(std::abs(corner.x), 1);
    EXPECT_EQ(std::abs(corner.y), 1);
  }
  EXPECT_FALSE(tracer.solid_triangle({kDown.origin, kDown.direction, 1.9f}).has_value()) << "ends before it";
  EXPECT_FALSE(tracer.solid_triangle({kDown.origin, {0, 0, 1}}).has_value());
}

TEST(SolidTriangle, IsNoneThatLetsRaysPass) {
  const Scene null = square_above(BsdfKind::null, 1), holes = square_above(BsdfKind::diffuse, 0.999f);
  EXPECT_FALSE(Tracer(null).solid_triangle(kDown).has_value());
  EXPECT_FALSE(Tracer(holes).solid_triangle(kDown).has_value());
}

}  // namespace
}  // namespace myrialux
