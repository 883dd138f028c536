// Picture files against a reference: what is read, what is refused and how, and the keys of the JSON.
#include "myrialux/report/comparison.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "myrialux/base/error.h"
#include "support/picture_files.h"
#include "support/temporary_folder.h"

namespace myrialux {
namespace {

using nlohmann::ordered_json;
using test::write_gray;
using test::write_with_nan;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

class Compare : public testing::Test {
 protected:
  test::TemporaryFolder folder;
  std::string truth = write_gray(folder.file("truth.exr"), 4, 3, 2), a = write_gray(folder.file("a.exr"), 4, 3, 3);

  /// The message and kind of what must be refused.
  Error refusal(const std::string& reference, const std::vector<std::string>& images,
                const ComparisonOptions& options = {}) const {
    try {
      compare_pictures(reference, images, options);
    } catch (const Error& e) {
      return e;
    }
    ADD_FAILURE() << "nothing was refused";
    return {ErrorKind::usage, ""};
  }
};

TEST_F(Compare, MeasuresEveryPictureInTheOrderGiven) {
  const std::string b = write_gray(folder.file("b.exr"), 4, 3, 2.5f);
  const Comparison c = compare_pictures(truth, {a, b, truth});
  ASSERT_EQ(c.images.size(), 3u);
  EXPECT_NEAR(c.images[0].errors.rgb.relative_rmse, 0.5, 1e-6);
  EXPECT_NEAR(c.images[1].errors.rgb.relative_rmse, 0.25, 1e-6);
  EXPECT_EQ(c.images[2].errors.rgb.relative_rmse, 0);
  EXPECT_THAT(by_error(c), ElementsAre(2, 1, 0));
  EXPECT_EQ(c.images[0].picture.name, "a");
}

TEST_F(Compare, PicturesOfTheSameNameAreToldApartByTheirPaths) {
  std::filesystem::create_directory(folder.path() / "old");
  const std::string other = write_gray(folder.file("old/a.exr"), 4, 3, 1);
  const Comparison c = compare_pictures(truth, {a, other});
  EXPECT_EQ(c.images[0].picture.name, a);
  EXPECT_EQ(c.images[1].picture.name, other);
}

TEST_F(Compare, RegionLimitsEverything) {
  const std::string spotted = write_with_nan(folder.file("spotted.exr"), 4, 3, 2);  // in the first pixel
  const Comparison c = compare_pictures(truth, {spotted}, {.region = Region{1, 1, 3, 2}});
  EXPECT_EQ(c.reference.pixels.size(), 6u);
  EXPECT_EQ(c.images[0].errors.rgb.rmse, 0);
}

TEST_F(Compare, AllMistakesAreToldAtOnce) {
  const std::string small = write_gray(folder.file("small.exr"), 2, 3, 2),
                    odd = write_gray(folder.file("odd.exr"), 5, 7, 2),
                    spotted = write_with_nan(folder.file("spotted.exr"), 4, 3, 2),
                    colourless = write_gray(folder.file("depth.exr"), 4, 3, 2, {"Z"}),
                    broken = folder.write("broken.exr", "no picture");
  const Error e = refusal(truth, {a, small, odd, spotted, colourless, broken, folder.file("none.exr")});
  EXPECT_EQ(e.kind(), ErrorKind::input);
  const std::string message = e.what();
  EXPECT_EQ(std::count(message.begin(), message.end(), '\n'), 5) << message;
  EXPECT_THAT(message, HasSubstr("small.exr: has 2x3 pixels, the reference " + truth + " has 4x3"));
  EXPECT_THAT(message, HasSubstr("oiiotool " + truth + " --resize:filter=box 2x3"));
  EXPECT_THAT(message, HasSubstr("odd.exr: has 5x7 pixels"));
  EXPECT_THAT(message, HasSubstr("spotted.exr: 1 of its pixels is not finite, the first at 0,0 with 2 nan 2"));
  EXPECT_THAT(message, HasSubstr("depth.exr: has no channels R, G and B (it has Z)"));
  EXPECT_THAT(message, HasSubstr("broken.exr: cannot be read"));
  EXPECT_THAT(message, HasSubstr("none.exr: cannot be read: there is no such file"));
  EXPECT_THAT(message, Not(HasSubstr("a.exr: ")));
}

TEST_F(Compare, FaultsOfTheReferenceAreToldWithThoseOfThePictures) {
  const std::string nan = write_with_nan(folder.file("nan.exr"), 4, 3, 2);
  EXPECT_THAT(refusal(nan, {folder.file("none.exr")}).what(), AllOf(HasSubstr("nan.exr: 1 of"), HasSubstr("none.exr")));
  EXPECT_THAT(refusal(folder.file("none.exr"), {nan}).what(), Not(HasSubstr("has 4x3"))) << "sizes of nothing";
}

TEST_F(Compare, RegionsThatReachOutAreRefused) {
  for (const Region& r : {Region{1, 0, 4, 3}, Region{0, 0, 4, 4}, Region{4, 0, 1, 1}, Region{-1, 0, 1, 1},
                          Region{0, 0, 0, 1}, Region{2147483647, 0, 2147483647, 1}})
    EXPECT_THAT(refusal(truth, {a}, {.region = r}).what(), HasSubstr("4x3 pixels; the region"));
}

TEST_F(Compare, JsonHasTheKeysOfTheContract) {
  Comparison c = compare_pictures(truth, {a, truth});
  const ordered_json j = ordered_json::parse(to_json(c));
  const auto keys = [](const ordered_json& object) {
    std::vector<std::string> names;
    for (const auto& [name, value] : object.items()) names.push_back(name);
    return names;
  };
  EXPECT_THAT(keys(j), ElementsAre("version", "size", "region", "exposure", "reference", "flip_settings", "images"));
  EXPECT_THAT(keys(j["images"][0]), ElementsAre("path", "name", "luminance", "rgb", "mean_rgb", "mean_rgb_ratio",
                                                "flip", "flip_shown", "header"));
  for (const char* group : {"luminance", "rgb"})
    EXPECT_THAT(
        keys(j["images"][0][group]),
        ElementsAre("mean_reference", "mean", "relative_rmse", "relative_rmse_without_worst", "relative_rmse_room",
                    "relmse", "rmse", "mae", "bias", "differing_share", "differing_pixels", "psnr_db"));
  EXPECT_EQ(j["size"], ordered_json({4, 3}));
  EXPECT_EQ(j["region"], ordered_json({0, 0, 4, 3}));
  EXPECT_NEAR(j["images"][0]["luminance"]["bias"].get<double>(), 0.5, 1e-6);
  EXPECT_EQ(j["images"][0]["mean_rgb_ratio"], ordered_json({1.5, 1.5, 1.5}));
  EXPECT_EQ(j["images"][0]["header"]["myrialux.method"], "test");
  EXPECT_TRUE(j["images"][1]["rgb"]["psnr_db"].is_null()) << "infinite";
  EXPECT_TRUE(j["images"][0]["flip"].is_null()) << "not evaluated";
  c.flip = FlipSettings{67, -2, 3, 5, "aces"};
  EXPECT_EQ(ordered_json::parse(to_json(c))["flip_settings"]["exposures"], 5);
}

}  // namespace
}  // namespace myrialux
