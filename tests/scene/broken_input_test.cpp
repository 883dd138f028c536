// Every mistake in an input is told with its place and what is allowed, all of them in one go.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "scene_text.h"

namespace myrialux {
namespace {

using test::complaint;
using test::TemporaryFolder;
using ::testing::HasSubstr;
using ::testing::StartsWith;

struct Broken {
  const char* name;
  const char* scene;    ///< line 1 opens the scene with camera and light; this starts on line 2
  const char* message;  ///< the whole message
};
std::ostream& operator<<(std::ostream& out, const Broken& b) { return out << b.name; }

class BrokenScene : public testing::TestWithParam<Broken> {};

TEST_P(BrokenScene, IsRefusedWithPlaceAndRemedy) {
  const TemporaryFolder folder;
  const std::string text =
      std::string("<scene version=\"3.0.0\">") + test::kCamera + test::kLight + "\n" + GetParam().scene + "\n</scene>";
  EXPECT_EQ(complaint(folder, folder.write("s.xml", text)), GetParam().message);
}

const Broken kScenes[] = {
    {"UnknownBsdf", "<bsdf type=\"difuse\"/>",
     "s.xml:2:1: unknown bsdf \"difuse\"; did you mean \"diffuse\"?; allowed: diffuse, conductor, roughconductor, "
     "plastic, "
     "roughplastic, dielectric, thindielectric, roughdielectric, twosided, mask, bumpmap, normalmap, null"},
    {"UnknownShape", " <shape type=\"sphare\"/>",
     "s.xml:2:2: unknown shape \"sphare\"; did you mean \"sphere\"?; allowed: obj, ply, serialized, rectangle, cube, "
     "sphere, "
     "disk, cylinder, shapegroup, instance"},
    {"UnknownEmitter", "<emitter type=\"xyzzy\"/>",
     "s.xml:2:1: unknown emitter \"xyzzy\"; allowed: area, constant, envmap, point, spot, directional"},
    {"UnknownElement", "<shap type=\"cube\"/>", "s.xml:2:1: unknown element <shap>; did you mean \"shape\"?"},
    {"UnknownTransformStep",
     "<shape type=\"cube\"><transform name=\"to_world\">\n<rotation z=\"1\" angle=\"3\"/></transform></shape>",
     "s.xml:3:1: unknown element <rotation> in a transform; allowed: translate, rotate, "
     "scale, "
     "lookat, matrix"},
    {"UnknownReference", "<bsdf type=\"diffuse\" id=\"wall\"/><shape type=\"cube\">\n  <ref id=\"wal\"/></shape>",
     "s.xml:3:3: reference to an unknown id \"wal\"; did you mean \"wall\"?"},
    {"SameIdTwice", "<bsdf type=\"diffuse\" id=\"a\"/>\n<bsdf type=\"null\" id=\"a\"/>",
     "s.xml:3:1: id \"a\" is given twice; first at s.xml:2:1"},
    {"SamePropertyTwice",
     "<shape type=\"sphere\"><float name=\"radius\" value=\"1\"/>\n<float name=\"radius\" value=\"2\"/></shape>",
     "s.xml:3:1: property \"radius\" is given twice; first at s.xml:2:22"},
    {"NotANumber", "<shape type=\"sphere\">\n<float name=\"radius\" value=\"1.5x\"/></shape>",
     "s.xml:3:1: float \"radius\" is \"1.5x\"; allowed: a finite number"},
    {"InfiniteNumber", "<shape type=\"sphere\">\n<float name=\"radius\" value=\"inf\"/></shape>",
     "s.xml:3:1: float \"radius\" is \"inf\"; allowed: a finite number"},
    {"NotAWholeNumber", "<integrator type=\"path\">\n<integer name=\"max_depth\" value=\"2.5\"/></integrator>",
     "s.xml:3:1: integer \"max_depth\" is \"2.5\"; allowed: a whole number"},
    {"NotABoolean", "<shape type=\"cube\">\n<boolean name=\"flip_normals\" value=\"yes\"/></shape>",
     "s.xml:3:1: boolean \"flip_normals\" is \"yes\"; allowed: true, false"},
    {"WrongType", "<shape type=\"sphere\">\n<string name=\"radius\" value=\"big\"/></shape>",
     "s.xml:3:1: \"radius\" is a <string>; allowed: <float>"},
    {"NegativeRadius", "<shape type=\"sphere\">\n<float name=\"radius\" value=\"-0.5\"/></shape>",
     "s.xml:3:1: \"radius\" is -0.5; allowed: greater than 0"},
    {"BadColour", "<bsdf type=\"diffuse\">\n<rgb name=\"reflectance\" value=\"1, 2\"/></bsdf>",
     "s.xml:3:1: rgb \"reflectance\" is \"1, 2\"; allowed: one or three numbers, or #rrggbb"},
    {"BadHexadecimalColour", "<bsdf type=\"diffuse\">\n<rgb name=\"reflectance\" value=\"#12345\"/></bsdf>",
     "s.xml:3:1: rgb \"reflectance\" is \"#12345\"; allowed: # and six hexadecimal digits"},
    {"ReflectanceAboveOne", "<bsdf type=\"diffuse\">\n<rgb name=\"reflectance\" value=\"0.5 1.5 0\"/></bsdf>",
     "s.xml:3:1: \"reflectance\" is 0.5, 1.5, 0; allowed: 0 to 1"},
    {"NegativeRadiance",
     "<shape type=\"cube\"><emitter type=\"area\">\n<rgb name=\"radiance\" value=\"-1\"/></emitter></shape>",
     "s.xml:3:1: \"radiance\" is -1, -1, -1; allowed: 0 and above"},
    {"OpacityAboveOne", "<bsdf type=\"mask\"><bsdf type=\"diffuse\"/>\n<float name=\"opacity\" value=\"1.25\"/></bsdf>",
     "s.xml:3:1: \"opacity\" is 1.25; allowed: 0 to 1"},
    {"NegativeRoughness", "<bsdf type=\"roughconductor\">\n<float name=\"alpha\" value=\"-0.1\"/></bsdf>",
     "s.xml:3:1: \"alpha\" is -0.1; allowed: 0 to 10"},
    {"BadSpectrum", "<bsdf type=\"diffuse\">\n<spectrum name=\"reflectance\" value=\"500:1, 400:1\"/></bsdf>",
     "s.xml:3:1: spectrum \"reflectance\": allowed: at least two wavelength:value pairs with rising wavelengths in nm"},
    {"SingularTransform", "<shape type=\"cube\">\n<transform name=\"to_world\"><scale x=\"0\"/></transform></shape>",
     "s.xml:3:1: transform \"to_world\" cannot be inverted; allowed: scales that are not 0"},
    {"ProjectiveMatrix",
     "<shape type=\"cube\"><transform name=\"to_world\">\n<matrix value=\"1 0 0 0 0 1 0 0 0 0 1 0 0 0 1 "
     "1\"/></transform></shape>",
     "s.xml:3:1: <matrix> needs 0 0 0 1 as its last row"},
    {"ShortMatrix", "<shape type=\"cube\"><transform name=\"to_world\">\n<matrix value=\"1 0 0\"/></transform></shape>",
     "s.xml:3:1: <matrix> needs a value of 9 or 16 numbers"},
    {"LookAlongUp",
     "<shape type=\"cube\"><transform name=\"to_world\">\n<lookat origin=\"0 0 0\" target=\"0 1 0\" up=\"0 1 "
     "0\"/></transform></shape>",
     "s.xml:3:1: <lookat>: origin and target must differ and up must not point along the view"},
    {"MissingMesh", "<shape type=\"ply\">\n<string name=\"filename\" value=\"a b.ply\"/></shape>",
     "s.xml:3:1: mesh file a b.ply does not exist"},
    {"MissingTexture", "<texture type=\"bitmap\">\n<string name=\"filename\" value=\"w.jpg\"/></texture>",
     "s.xml:3:1: image w.jpg does not exist"},
    {"MissingFilename", "<shape type=\"obj\"/>", "s.xml:2:1: shape \"obj\" needs a filename"},
    {"MissingInclude", "<include filename=\"x.xml\"/>",
     "s.xml:2:1: included file \"x.xml\" does not exist (looked for x.xml)"},
    {"IncludesItself", "<include filename=\"s.xml\"/>", "s.xml:2:1: files include each other: s.xml -> s.xml"},
    {"UndefinedParameter", "<integrator type=\"$kind\"/>",
     "s.xml:2:1: undefined parameter $kind; give it with -D kind=VALUE or <default name=\"kind\" value=\"...\"/>"},
    {"SecondCamera", "<sensor type=\"perspective\"/>", "s.xml:2:1: a second sensor; allowed: one"},
    {"SecondEnvironment", "<emitter type=\"constant\"/>",
     "s.xml:2:1: a second environment; allowed: one. First at s.xml:1:52"},
    {"AreaEmitterInTheScene", "<emitter type=\"area\"/>",
     "s.xml:2:1: emitter \"area\" stands in the scene itself; allowed: inside a shape"},
    {"AreaEmitterInAGroup",
     "<shape type=\"shapegroup\"><shape type=\"cube\">\n<emitter type=\"area\"/></shape></shape>",
     "s.xml:3:1: an area emitter on an instanced shape; allowed: emitters on shapes that stand alone"},
    {"InstanceOfNothing", "<shape type=\"instance\"/>",
     "s.xml:2:1: instance names no shapegroup; add <ref id=\"...\"/>"},
    {"TwoMaterials", "<shape type=\"cube\"><bsdf type=\"null\"/>\n<bsdf type=\"null\"/></shape>",
     "s.xml:3:1: a second bsdf on a shape; allowed: one"},
    {"EmptyTwosided", "<bsdf type=\"twosided\"/>", "s.xml:2:1: bsdf \"twosided\" holds 0 BSDFs; allowed: 1 or 2"},
    {"TwosidedGlass", "<bsdf type=\"twosided\"><bsdf type=\"dielectric\"/></bsdf>",
     "s.xml:2:1: bsdf \"twosided\" holds a BSDF that lets light through; allowed: BSDFs that only reflect"},
    {"HoldsItself", "<bsdf type=\"twosided\" id=\"a\">\n<ref id=\"a\"/></bsdf>", "s.xml:3:1: bsdf \"a\" holds itself"},
    {"UnknownGlass", "<bsdf type=\"dielectric\">\n<string name=\"int_ior\" value=\"watr\"/></bsdf>",
     "s.xml:3:1: \"int_ior\" is \"watr\"; did you mean \"water\"?; allowed: vacuum, helium, hydrogen, air, carbon "
     "dioxide, "
     "water, acetone, ethanol, carbon tetrachloride, glycerol, benzene, silicone oil, bromine, water ice, fused "
     "quartz, pyrex, "
     "acrylic glass, polypropylene, bk7, sodium chloride, amber, pet, diamond"},
    {"UnknownDistribution", "<bsdf type=\"roughplastic\">\n<string name=\"distribution\" value=\"gxx\"/></bsdf>",
     "s.xml:3:1: \"distribution\" is \"gxx\"; did you mean \"ggx\"?; allowed: beckmann, ggx, phong, as"},
    {"TextInAScene", "hello", "s.xml:1:1: <scene> holds text; allowed: elements and attributes"},
    {"UnclosedElement", "<shape type=\"cube\">\n", "s.xml:4:3: not well-formed XML: Start-end tags mismatch"},
    {"UnknownAttribute", "<shape type=\"cube\" nmae=\"x\"/>",
     "s.xml:2:1: <shape> has an unknown attribute nmae; allowed: type, id, name"},
    {"FilmInTheScene", "<film type=\"hdrfilm\"/>",
     "s.xml:2:1: <film> stands in the scene itself; allowed: bsdf, emitter, integrator, medium, sensor, shape, "
     "texture"},
};
INSTANTIATE_TEST_SUITE_P(All, BrokenScene, testing::ValuesIn(kScenes), [](const auto& p) { return p.param.name; });

class BrokenCamera : public testing::TestWithParam<Broken> {};

TEST_P(BrokenCamera, IsRefusedWithPlaceAndRemedy) {
  const TemporaryFolder folder;
  const std::string text = std::string("<scene version=\"3.0.0\">") + test::kLight + "<sensor type=\"perspective\">\n" +
                           GetParam().scene + "</sensor></scene>";
  EXPECT_EQ(complaint(folder, folder.write("s.xml", text)), GetParam().message);
}

const Broken kCameras[] = {
    {"WideView", "<float name=\"fov\" value=\"180\"/>",
     "s.xml:2:1: \"fov\" is 180; allowed: greater than 0, less than 180 (degrees)"},
    {"NegativeView", "<float name=\"fov\" value=\"-1\"/>",
     "s.xml:2:1: \"fov\" is -1; allowed: greater than 0, less than 180 (degrees)"},
    {"UnknownAxis", "<string name=\"fov_axis\" value=\"z\"/>",
     "s.xml:2:1: \"fov_axis\" is \"z\"; allowed: x, y, diagonal, smaller, larger"},
    {"WideFilm", "<film type=\"hdrfilm\"><integer name=\"width\" value=\"65537\"/></film>",
     "s.xml:2:22: \"width\" is 65537; allowed: 1 to 65536"},
    {"EmptyFilm", "<film type=\"hdrfilm\"><integer name=\"height\" value=\"0\"/></film>",
     "s.xml:2:22: \"height\" is 0; allowed: 1 to 65536"},
    {"LargeFilm",
     "<film type=\"hdrfilm\"><integer name=\"width\" value=\"65536\"/><integer name=\"height\" "
     "value=\"65536\"/></film>",
     "s.xml:2:1: film of 65536 x 65536 pixels; allowed: at most 2^28 pixels"},
    {"UnknownFilter", "<film type=\"hdrfilm\"><rfilter type=\"gausian\"/></film>",
     "s.xml:2:22: unknown rfilter \"gausian\"; did you mean \"gaussian\"?; allowed: box, tent, gaussian, mitchell, "
     "catmullrom, "
     "lanczos"},
    {"NoSamples", "<sampler type=\"independent\"><integer name=\"sample_count\" value=\"0\"/></sampler>",
     "s.xml:2:29: \"sample_count\" is 0; allowed: 1 to 1073741824"},
    {"ScaledCamera", "<transform name=\"to_world\"><scale value=\"2\"/></transform>",
     "s.xml:2:1: the camera is scaled by 2; allowed: rotations, translations, mirrors"},
    {"FarBeforeNear", "<float name=\"near_clip\" value=\"10\"/>\n<float name=\"far_clip\" value=\"5\"/>",
     "s.xml:3:1: far clip 5 must exceed near clip 10"},
};
INSTANTIATE_TEST_SUITE_P(All, BrokenCamera, testing::ValuesIn(kCameras), [](const auto& p) { return p.param.name; });

#define KEY(time, step) "<transform time=\"" time "\">" step "</transform>\n"
#define MOTION(keys) "<animation name=\"to_world\">\n" keys "</animation>"
const Broken kMotions[] = {
    {"OneKeyframe", MOTION(KEY("0", "")), "s.xml:3:1: the only keyframe of an animation; allowed: two and more"},
    {"NoKeyframe", MOTION(""),
     "s.xml:2:1: animation \"to_world\" is empty; allowed: two <transform time=\"...\"> and more"},
    {"TimesFall", MOTION(KEY("0", "") KEY("1", "") KEY("0.5", "")),
     "s.xml:5:1: keyframe of time 0.5 after that of time 1; allowed: times that rise"},
    {"SameTimeTwice", MOTION(KEY("2", "") KEY("2", "")),
     "s.xml:4:1: keyframe of time 2 after that of time 2; allowed: times that rise"},
    {"KeyframeWithoutTime", MOTION("<transform/>\n" KEY("1", "")),
     "s.xml:3:1: <transform> of an animation has time \"\"; allowed: a finite number"},
    {"KeyframeOfAnotherKind", MOTION(KEY("0", "") "<float name=\"x\" value=\"1\"/>\n"),
     "s.xml:4:1: <float> has an unknown attribute name; allowed: time\n"
     "s.xml:4:1: <float> has an unknown attribute value; allowed: time\n"
     "s.xml:4:1: unknown element <float> in an animation; allowed: transform"},
    {"ScaledKeyframe", MOTION(KEY("0", "") KEY("1", "<scale value=\"3\"/>")),
     "s.xml:4:1: the camera is scaled by 3; allowed: rotations, translations, mirrors"},
    {"ShearedKeyframe", MOTION(KEY("0", "") KEY("1", "<matrix value=\"1 0.6 0  0 0.8 0  0 0 1\"/>")),
     "s.xml:4:1: the camera is sheared; allowed: rotations, translations, mirrors"},
    {"MirroredKeyframe", MOTION(KEY("0", "") KEY("1", "<scale x=\"-1\"/>")),
     "s.xml:4:1: one keyframe is mirrored, the first is not, or the reverse; allowed: all or none"},
    {"ClosesBeforeItOpens", "<float name=\"shutter_open\" value=\"1\"/>\n<float name=\"shutter_close\" value=\"0.5\"/>",
     "s.xml:3:1: the shutter closes at 0.5 but opens at 1; allowed: the same time or later"},
};
INSTANTIATE_TEST_SUITE_P(Motion, BrokenCamera, testing::ValuesIn(kMotions), [](const auto& p) { return p.param.name; });

class BrokenLens : public testing::TestWithParam<Broken> {};

TEST_P(BrokenLens, IsRefusedWithPlaceAndRemedy) {
  const TemporaryFolder folder;
  const std::string text = std::string("<scene version=\"0.6.0\">") + test::kLight + "<sensor type=\"thinlens\">\n" +
                           GetParam().scene + "</sensor></scene>";
  EXPECT_EQ(complaint(folder, folder.write("s.xml", text)), GetParam().message);
}

const Broken kLenses[] = {
    {"NoAperture", "", "s.xml:1:50: sensor \"thinlens\" needs an aperture_radius, 0 and above (scene units)"},
    {"NegativeAperture", "<float name=\"apertureRadius\" value=\"-0.1\"/>",
     "s.xml:2:1: \"apertureRadius\" is -0.1; allowed: 0 and above"},
    {"ApertureOfWords", "<string name=\"apertureRadius\" value=\"wide\"/>",
     "s.xml:2:1: \"apertureRadius\" is a <string>; allowed: <float>"},
    {"NoFocus", "<float name=\"apertureRadius\" value=\"1\"/>\n <float name=\"focusDistance\" value=\"0\"/>",
     "s.xml:3:2: \"focusDistance\" is 0; allowed: greater than 0"},
};
INSTANTIATE_TEST_SUITE_P(All, BrokenLens, testing::ValuesIn(kLenses), [](const auto& p) { return p.param.name; });

TEST(BrokenInput, WhatIsMissingAltogetherIsToldAtTheScene) {
  const TemporaryFolder folder;
  EXPECT_EQ(complaint(folder, folder.write("s.xml", "\n<scene version=\"3.0.0\"/>")),
            "s.xml:2:1: the scene has no sensor; add <sensor type=\"perspective\">\n"
            "s.xml:2:1: the scene has no light; add an <emitter>, on a shape or in the scene");
  EXPECT_EQ(complaint(folder, folder.file("none.xml")), "none.xml: cannot be read; check that the file exists");
  EXPECT_EQ(complaint(folder, folder.write("s.pdf", "")),
            "s.pdf: unknown kind of scene file \".pdf\"; allowed: .xml (Mitsuba), .obj (Wavefront)");
  EXPECT_EQ(complaint(folder, folder.write("s.xml", "<sene/>")), "s.xml:1:1: root element is <sene>; allowed: <scene>");
  EXPECT_THAT(complaint(folder, folder.write("s.xml", "")), StartsWith("s.xml:1:1: not well-formed XML: "));
}

TEST(BrokenInput, AllMistakesAreToldAtOnce) {
  const TemporaryFolder folder;
  folder.write("t.obj", "v 0 0\nf 1 2 3\n");
  const std::string message = complaint(
      folder,
      folder.write("s.xml",
                   test::scene_with(
                       "\n<bsdf type=\"difuse\"/>\n<shape type=\"sphere\"><float name=\"radius\" value=\"0\"/></shape>"
                       "\n<shape type=\"obj\"><string name=\"filename\" value=\"t.obj\"/></shape>")));
  EXPECT_THAT(message, HasSubstr("s.xml:2:1: unknown bsdf"));
  EXPECT_THAT(message, HasSubstr("\ns.xml:3:22: \"radius\" is 0"));
  EXPECT_THAT(message, HasSubstr("\nt.obj:1: v has too few numbers"));
  EXPECT_THAT(message, HasSubstr("\nt.obj:2: face names vertex 1, but 0 are known so far"));
}

TEST(BrokenInput, IncludesInACircleNameTheirChain) {
  const TemporaryFolder folder;
  folder.write("a.xml", "<scene version=\"3.0.0\">\n <include filename=\"b.xml\"/></scene>");
  folder.write("b.xml", "<scene version=\"3.0.0\"><include filename=\"a.xml\"/></scene>");
  EXPECT_EQ(complaint(folder, folder.file("a.xml")), "b.xml:1:24: files include each other: a.xml -> b.xml -> a.xml");
}

TEST(BrokenInput, MistakesInIncludedFilesHaveTheirPlaceThere) {
  const TemporaryFolder folder;
  folder.write("i.xml", "<scene version=\"3.0.0\">\n\n   <bsdf type=\"x\"/></scene>");
  EXPECT_THAT(complaint(folder, folder.write("s.xml", test::scene_with("<include filename=\"i.xml\"/>"))),
              StartsWith("i.xml:3:4: unknown bsdf \"x\""));
}

TEST(BrokenInput, MessagesKeepTheSpellingOfTheOldDialect) {
  const TemporaryFolder folder;
  const std::string text =
      test::scene_with("<bsdf type=\"plastic\"><float name=\"intIOR\" value=\"-1\"/></bsdf>", "0.5.0");
  EXPECT_THAT(complaint(folder, folder.write("s.xml", text)), HasSubstr("\"intIOR\" is -1; allowed: greater than 0"));
}

TEST(BrokenInput, DeepNestingIsRefusedWithoutHarm) {
  const TemporaryFolder folder;
  std::string open, close;
  for (int i = 0; i < 20000; ++i) open += "<bsdf type=\"twosided\">", close += "</bsdf>";
  EXPECT_THAT(complaint(folder, folder.write("s.xml", test::scene_with(open + close))),
              HasSubstr("elements nest deeper than 100 levels"));
  std::string chain;
  for (int i = 0; i < 20000; ++i)
    chain +=
        "<bsdf type=\"mask\" id=\"m" + std::to_string(i) + "\"><ref id=\"m" + std::to_string(i + 1) + "\"/></bsdf>";
  chain += "<bsdf type=\"diffuse\" id=\"m20000\"/>";
  EXPECT_THAT(complaint(folder, folder.write("s.xml", test::scene_with(chain))),
              HasSubstr("objects nest deeper than 100 levels"));
}

struct BrokenMesh {
  const char* name;
  const char* file;
  const char* text;
  const char* message;
};
class BrokenMeshFile : public testing::TestWithParam<BrokenMesh> {};

TEST_P(BrokenMeshFile, IsRefusedWithLineOrByte) {
  const TemporaryFolder folder;
  const std::string file = GetParam().file, kind = file.substr(file.find('.') + 1);
  folder.write(file, GetParam().text);
  const std::string text =
      test::scene_with("<shape type=\"" + kind + "\"><string name=\"filename\" value=\"" + file + "\"/></shape>");
  EXPECT_EQ(complaint(folder, folder.write("s.xml", text)), GetParam().message);
}

#define PLY_XYZ "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
#define PLY_FACE "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
std::ostream& operator<<(std::ostream& out, const BrokenMesh& b) { return out << b.name; }
const BrokenMesh kMeshes[] = {
    {"ObjIndexOutOfRange", "t.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n\nf 1 2 4\n",
     "t.obj:5: face names vertex 4, but 3 are known so far; allowed: 1 to 3, or -1 to -3"},
    {"ObjIndexZero", "t.obj", "v 0 0 0\nf 0 1 1\n",
     "t.obj:2: face names vertex 0, but 1 are known so far; allowed: 1 to 1, or -1 to -1"},
    {"ObjNotANumber", "t.obj", "v 0 zero 0\n", "t.obj:1: v: \"zero\" is not a finite number"},
    {"ObjNotFinite", "t.obj", "v 0 nan 0\n", "t.obj:1: v: \"nan\" is not a finite number"},
    {"ObjTwoCorners", "t.obj", "v 0 0 0\nv 1 0 0\nf 1 2\n", "t.obj:3: face has 2 corners; allowed: 3 and more"},
    {"ObjMissingNormal", "t.obj", "v 0 0 0\nf 1//1 1//1 1//1\n",
     "t.obj:2: face names normal 1, but 0 are known so far; allowed: 1 to 0, or -1 to -0"},
    {"ObjThatIsNot", "t.obj",
     "\x7f"
     "ELF\n",
     "t.obj:1: not an OBJ line: \"\x7f"
     "ELF\""},
    {"PlyThatIsNot", "t.ply", "solid x\n", "t.ply:1: not a PLY file: the first line must be \"ply\""},
    {"PlyWithoutEnd", "t.ply", "ply\nformat ascii 1.0\n", "t.ply:2: the header has no end_header"},
    {"PlyUnknownFormat", "t.ply", "ply\nformat zip 1.0\n",
     "t.ply:2: unknown format; allowed: ascii, binary_little_endian, binary_big_endian"},
    {"PlyUnknownType", "t.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty half x\n",
     "t.ply:4: allowed: property TYPE NAME, property list COUNT_TYPE TYPE NAME"},
    {"PlyCountTooLarge", "t.ply",
     "ply\nformat ascii 1.0\nelement vertex 4000000000\nproperty float x\nproperty float y\n"
     "property float z\nend_header\n0 0 0\n",
     "t.ply:8: the header promises 4000000000 rows of vertex, more than the file can hold"},
    {"PlyIndexOutOfRange", "t.ply", "ply\nformat ascii 1.0\n" PLY_XYZ PLY_FACE "0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n",
     "t.ply: a face names vertex 3; allowed: 0 to 2"},
    {"PlyNegativeIndex", "t.ply", "ply\nformat ascii 1.0\n" PLY_XYZ PLY_FACE "0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n",
     "t.ply:13: a face names vertex -1"},
    {"PlyNotANumber", "t.ply", "ply\nformat ascii 1.0\n" PLY_XYZ PLY_FACE "0 0 0\n1 b 0\n0 1 0\n3 0 1 2\n",
     "t.ply:11: \"b\" is not a finite number"},
    {"PlyEndsEarly", "t.ply", "ply\nformat ascii 1.0\n" PLY_XYZ PLY_FACE "0 0 0\n1 0 0\n0 1 0\n3 0 1",
     "t.ply:13: the file ends too early"},
    {"PlyBinaryEndsEarly", "t.ply", "ply\nformat binary_little_endian 1.0\n" PLY_XYZ PLY_FACE "0123",
     "t.ply: byte 169: the header promises 3 rows of vertex, more than the file can hold"},
    {"PlyWithoutPositions", "t.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n0\n",
     "t.ply:6: vertices need the properties x, y, z"},
    {"SerializedThatIsNot", "t.serialized", "0123456789", "t.serialized: not a serialized mesh file of Mitsuba"},
};
INSTANTIATE_TEST_SUITE_P(All, BrokenMeshFile, testing::ValuesIn(kMeshes), [](const auto& p) { return p.param.name; });

TEST(BrokenInput, NonFiniteVerticesOfBinaryFilesAreRefused) {
  const TemporaryFolder folder;
  std::string ply = "ply\nformat binary_little_endian 1.0\n" PLY_XYZ PLY_FACE + std::string(36, '\0') +
                    std::string("\x03\0\0\0\0\x01\0\0\0\x02\0\0\0", 13);
  ply.replace(ply.size() - 13 - 24, 4, "\xff\xff\xff\x7f", 4);  // vertex 1, x: a NaN
  folder.write("t.ply", ply);
  EXPECT_EQ(
      complaint(folder,
                folder.write("s.xml", test::scene_with(
                                          "<shape type=\"ply\"><string name=\"filename\" value=\"t.ply\"/></shape>"))),
      "t.ply: vertex 1 is not finite");
}

}  // namespace
}  // namespace myrialux
