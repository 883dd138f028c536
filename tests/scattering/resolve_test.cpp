// Textures, sides and kinds of materials on their way to parameters.
#include <gtest/gtest.h>

#include "myrialux/scattering/bsdf.h"

namespace myrialux {
namespace {

constexpr MaterialId kFirst = static_cast<MaterialId>(0), kSecond = static_cast<MaterialId>(1);

/// One material and a checkerboard of 0.25 (lower left quarter) and 0.75.
Scene checkered() {
  Scene scene;
  Texture texture;
  texture.kind = Texture::Kind::checkerboard;
  texture.color0 = {0.25f, 0.5f, 0.125f};
  texture.color1 = gray(0.75f);
  scene.textures.push_back(texture);
  scene.materials.resize(2);
  return scene;
}

TEST(Resolve, ConstantColoursPassUnchanged) {
  Scene scene = checkered();
  scene.materials[0].reflectance.value = {0.1f, 0.2f, 0.3f};
  scene.materials[0].specular.value = {0.4f, 0.5f, 0.6f};
  scene.materials[0].alpha.value = gray(0.35f);
  const BsdfParams params = resolve(scene, kFirst, {0.2f, 0.9f}, true);
  EXPECT_EQ(params.material, kFirst);
  EXPECT_EQ(params.reflectance, (Rgb{0.1f, 0.2f, 0.3f}));
  EXPECT_EQ(params.specular, (Rgb{0.4f, 0.5f, 0.6f}));
  EXPECT_NEAR(params.alpha, 0.35f, 1e-7f);
}

TEST(Resolve, TexturesAreLookedUpAndScaled) {
  Scene scene = checkered();
  Material& m = scene.materials[0];
  m.reflectance = {gray(1), static_cast<TextureId>(0)};
  m.specular = {gray(0.5f), static_cast<TextureId>(0)};
  m.alpha = {gray(0.8f), static_cast<TextureId>(0)};
  for (const Vec2 uv : {Vec2{0.2f, 0.2f}, Vec2{0.2f, 0.8f}}) {
    const Rgb texel = evaluate(scene.textures[0], uv);
    const BsdfParams params = resolve(scene, kFirst, uv, true);
    EXPECT_EQ(params.reflectance, texel);
    EXPECT_EQ(params.specular, texel * 0.5f);
    EXPECT_NEAR(params.alpha, 0.8f * mean(texel), 1e-6f);
  }
}

TEST(Resolve, DielectricsKeepTheirTransmittanceInTheParameters) {
  Scene scene = checkered();
  Material& m = scene.materials[0];
  m.kind = BsdfKind::dielectric;
  m.transmittance = {{1, 0.5f, 0.25f}, static_cast<TextureId>(0)};
  const Vec2 uv{0.2f, 0.2f};
  const Bsdf bsdf = make_bsdf(m, resolve(scene, kFirst, uv, true), kDefaultSharpAlpha);
  EXPECT_EQ(bsdf.transmittance, m.transmittance.value * evaluate(scene.textures[0], uv));
  EXPECT_EQ(bsdf.specular, gray(1));
}

TEST(Resolve, BackOfTwoSidedSurfacesMayBeAnotherMaterial) {
  Scene scene = checkered();
  scene.materials[0].two_sided = true;
  EXPECT_EQ(resolve(scene, kFirst, {}, false).material, kFirst);
  scene.materials[0].back = kSecond;
  EXPECT_EQ(resolve(scene, kFirst, {}, false).material, kSecond);
  EXPECT_EQ(resolve(scene, kFirst, {}, true).material, kFirst);
  scene.materials[0].two_sided = false;
  EXPECT_EQ(resolve(scene, kFirst, {}, false).material, kFirst);
}

}  // namespace
}  // namespace myrialux
