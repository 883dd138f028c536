// Frames held in bands of rows: the same bits whatever the bands, and memory that samples a pixel do not raise.
#include <gtest/gtest.h>

#include <cmath>

#include "myrialux/pipeline/memory.h"
#include "myrialux/pipeline/pipeline.h"
#include "support/build_scene.h"

namespace myrialux {
namespace {

/// The varnished box seen by a moving camera with a lens.
Scene blurred_box() {
  Scene scene = test::plastic_floor_box();
  Camera& camera = scene.camera;
  camera.aperture_radius = 0.2f, camera.focus_distance = 3.5f;
  camera.motion = {{0, camera.to_world},
                   {1, Transform::translate({0.3f, 0.1f, 0}) * camera.to_world * Transform::rotate({0, 0, 1}, 8)}};
  camera.shutter_close = 1;
  scene.film.filter = {Filter::Kind::tent, 1};  // reaches into the next band
  return scene;
}

RenderParams small(const char* method) {
  RenderParams p;
  p.method = method;
  p.width = 13, p.height = 11;
  p.spp = 9;
  p.n_lights = 200;
  p.max_depth = 5;
  p.passes = 2;
  p.threads = 2;
  return p;
}

class Bands : public testing::TestWithParam<const char*> {};

TEST_P(Bands, GiveTheBitsOfTheWholeFrameWhateverTheirHeight) {
  const Scene scene = blurred_box();
  Progress silent;
  for (const auto direct : {RenderParams::Direct::vpl, RenderParams::Direct::sampled}) {
    RenderParams p = small(GetParam());
    p.direct = direct;
    const RenderOutput whole = render(scene, p, silent);
    for (const int rows : {1, 2, 5, 10}) {
      p.rows_at_once = rows;
      const RenderOutput banded = render(scene, p, silent);
      ASSERT_EQ(banded.picture.layers.size(), whole.picture.layers.size());
      for (std::size_t k = 0; k < whole.picture.layers.size(); ++k)
        EXPECT_EQ(banded.picture.layers[k].pixels, whole.picture.layers[k].pixels)
            << rows << " rows, layer " << whole.picture.layers[k].name;
      EXPECT_EQ(banded.stats.receivers, whole.stats.receivers);
      EXPECT_EQ(banded.stats.rays.shadow, whole.stats.rays.shadow);
      EXPECT_EQ(banded.stats.rays.compensation, whole.stats.rays.compensation);
      EXPECT_EQ(banded.stats.clusters_mean, whole.stats.clusters_mean);
      EXPECT_EQ(banded.stats.passes, whole.stats.passes);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Pipeline, Bands, testing::Values("mdlc", "brute-force"));

TEST(Bands, MemoryOfAPassDoesNotGrowWithSamplesAPixel) {
  FrameExtent few{.has_slices = false,
                  .has_pixel_cuts = true,
                  .band_samples = kBandSamples,
                  .width = 640,
                  .height = 360,
                  .spp = 64,
                  .n_lights = 100000,
                  .n_clusters = 10000};
  FrameExtent many = few;
  many.spp = 4096;
  EXPECT_EQ(rows_at_once(few), 12);
  EXPECT_EQ(rows_at_once(many), 1);
  // A row of pixels is the least: 5 times the samples of a band here, for 64 times the samples of the frame.
  EXPECT_LT(frame_bytes(many), 7 * frame_bytes(few));
  many.width = few.width = 100;
  EXPECT_LT(static_cast<double>(frame_bytes(many)), 1.1 * static_cast<double>(frame_bytes(few)));
}

}  // namespace
}  // namespace myrialux
