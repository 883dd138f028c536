// Damaged inputs are refused or read, never a crash: run under the address and undefined behaviour sanitizers.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "myrialux/base/rng.h"
#include "myrialux/scene/mesh.h"
#include "scene_text.h"

namespace myrialux {
namespace {

using test::TemporaryFolder;

/// Text cut short, with bytes changed, or with a piece repeated.
std::string damaged(std::string text, std::uint64_t item) {
  Rng rng({1, 0}, Stage::test, item);
  const auto place = [&] { return rng.below(static_cast<std::uint32_t>(text.size())); };
  const std::uint32_t kind = rng.below(4);
  if (kind == 0) return text.substr(0, place());
  if (kind == 1) return text.insert(place(), text.substr(place(), 1 + rng.below(40)));
  const std::uint32_t n_changes = 1 + rng.below(8);
  for (std::uint32_t i = 0; i < n_changes; ++i) {
    char& byte = text[place()];
    byte = kind == 2 ? static_cast<char>(byte ^ (1 << rng.below(8))) : static_cast<char>(rng.below(256));
  }
  return text;
}

/// Loads damaged copies of `name`; only Error may come out.
void fuzz(const TemporaryFolder& folder, const std::string& name, const std::string& text, const std::string& scene,
          int n_items) {
  for (int item = 0; item < n_items; ++item) {
    folder.write(name, damaged(text, static_cast<std::uint64_t>(item)));
    try {
      const Scene loaded = load_scene(folder.file(scene));
      for (const Mesh& mesh : loaded.meshes)
        for (const std::uint32_t v : mesh.indices) ASSERT_LT(v, mesh.positions.size());
      ASSERT_FALSE(loaded.bounds().lower.x != loaded.bounds().lower.x);
    } catch (const Error& error) {
      ASSERT_EQ(error.kind(), ErrorKind::input) << error.what();
    }
  }
}

const std::string kObj =
    "mtllib t.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0.5\nvn 0 0 1\nusemtl a\n"
    "f 1/1/1 2/2/1 3/1/1 4/2/1\nf -4//1 -3//1 -2//1\n";
const std::string kPly =
    "ply\nformat ascii 1.0\ncomment x\nelement vertex 4\nproperty float x\nproperty float y\n"
    "property float z\nproperty float nx\nproperty float ny\nproperty float nz\nelement face 2\n"
    "property list uchar int vertex_indices\nend_header\n0 0 0 0 0 1\n1 0 0 0 0 1\n1 1 0 0 0 1\n"
    "0 1 0 0 0 1\n4 0 1 2 3\n3 0 2 3\n";

void fuzz_xml(int n_items) {
  const TemporaryFolder folder;
  folder.write("t.obj", kObj);
  const std::string xml = R"(<?xml version="1.0"?>
<scene version="0.6.0">
  <default name="n" value="3"/>
  <integrator type="path"><integer name="maxDepth" value="$n"/></integrator>
  <sensor type="thinlens"><float name="fov" value="30"/><string name="fovAxis" value="smaller"/>
    <float name="apertureRadius" value="0.1"/><float name="focusDistance" value="5"/>
    <float name="shutterClose" value="0.5"/><animation name="toWorld">
    <transform time="0"><lookAt origin="0,0,5" target="0,0,0" up="0,1,0"/></transform>
    <transform time="1"><translate z="-5"/><rotate y="1" angle="170"/></transform></animation>
    <film type="hdrfilm"><integer name="width" value="16"/><rfilter type="gaussian"/></film></sensor>
  <bsdf type="twosided" id="m"><bsdf type="roughconductor"><string name="material" value="Au"/>
    <float name="alphaU" value="0.1"/><float name="alphaV" value="0.1"/></bsdf></bsdf>
  <texture type="checkerboard" id="t"><rgb name="color0" value="#ff8000"/></texture>
  <bsdf type="mask" id="leaf"><spectrum name="opacity" value="400:0.5 700:0.6"/>
    <bsdf type="diffuse"><ref id="t" name="reflectance"/></bsdf></bsdf>
  <shape type="shapegroup" id="g"><shape type="cube"><ref id="leaf"/></shape></shape>
  <shape type="instance"><ref id="g"/><transform name="toWorld"><rotate y="1" angle="30"/></transform></shape>
  <shape type="obj"><string name="filename" value="t.obj"/><ref id="m"/></shape>
  <shape type="sphere"><float name="radius" value="2"/><emitter type="area"><blackbody name="radiance" temperature="4000K"/></emitter></shape>
</scene>)";
  EXPECT_NO_THROW(load_scene(folder.write("s.xml", xml)));
  fuzz(folder, "s.xml", xml, "s.xml", n_items);
}

void fuzz_meshes(int n_items) {
  const TemporaryFolder folder;
  folder.write("t.mtl", "newmtl a\nKd 0.5 0.5 0.5\n");
  const auto scene = [&](const std::string& kind) {
    return folder.write(kind + ".xml",
                        test::scene_with("<shape type=\"" + kind + "\"><string name=\"filename\" value=\"t." + kind +
                                         "\"/></shape>")),
           kind + ".xml";
  };
  fuzz(folder, "t.obj", kObj, scene("obj"), n_items);
  fuzz(folder, "t.obj", kObj, "t.obj", n_items);
  fuzz(folder, "t.ply", kPly, scene("ply"), n_items);
  std::string binary =
      "ply\nformat binary_little_endian 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
      "property float z\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n";
  binary.append(48, '\0');
  for (int f = 0; f < 2; ++f) binary += std::string("\x03\0\0\0\0\x01\0\0\0\x02\0\0\0", 13);
  fuzz(folder, "t.ply", binary, "ply.xml", n_items);
  std::string big = binary;
  big.replace(big.find("little"), 6, "big");
  fuzz(folder, "t.ply", big, "ply.xml", n_items);
}

void fuzz_materials(int n_items) {
  const TemporaryFolder folder;
  folder.write("t.obj", kObj);
  fuzz(folder, "t.mtl", "newmtl a\nKd 0.1 0.2 0.3\nKs 1 1 1\nNs 100\nKe 1 1 1\nd 0.5\nTr 0.5\nmap_Kd -s 1 1 1 x.png\n",
       "t.obj", n_items);
}

TEST(Fuzz, DamagedXmlNeverCrashes) { fuzz_xml(150); }
TEST(Fuzz, DamagedMeshesNeverCrash) { fuzz_meshes(100); }
TEST(Fuzz, DamagedMaterialFilesNeverCrash) { fuzz_materials(100); }
TEST(Fuzz, SlowManyDamagedFilesNeverCrash) {
  fuzz_xml(2000);
  fuzz_meshes(1500);
  fuzz_materials(1000);
}

}  // namespace
}  // namespace myrialux
