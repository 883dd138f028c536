// Picture files: what is written comes back, and what cannot be written leaves nothing.
#include <OpenEXR/ImfThreading.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>

#include <bit>
#include <cmath>
#include <limits>

#include "myrialux/base/error.h"
#include "myrialux/base/parallel.h"
#include "myrialux/base/rng.h"
#include "myrialux/film/film.h"
#include "myrialux/math/srgb.h"
#include "support/temporary_folder.h"

namespace myrialux {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

Picture random_picture(int width, int height) {
  Picture picture{width, height, {}};
  Rng rng({5, 0}, Stage::test, 2);
  const auto add = [&](const char* name, std::vector<std::string> channels) {
    for (float& v : picture.add_layer(name, std::move(channels)).pixels) v = 4 * rng.next() - 1;
  };
  add("", {"R", "G", "B"});
  add("albedo", {"R", "G", "B"});
  add("normal", {"X", "Y", "Z"});
  add("depth", {"Z"});
  add("slice", {"id"});
  add("cut", {"size"});
  add("visibility", {"fraction"});
  return picture;
}

Picture beauty(int width, int height, Rgb value) {
  Picture picture{width, height, {}};
  std::vector<float>& pixels = picture.add_layer("", {"R", "G", "B"}).pixels;
  for (std::size_t i = 0; i < pixels.size(); i += 3)
    pixels[i] = value.r, pixels[i + 1] = value.g, pixels[i + 2] = value.b;
  return picture;
}

/// Runs f and gives the message and kind of the Error it must throw.
template <class F>
Error error_of(const F& f) {
  try {
    f();
  } catch (const Error& e) {
    return e;
  }
  ADD_FAILURE() << "no error was thrown";
  return {ErrorKind::usage, ""};
}

TEST(PictureFile, ExrLayersComeBackBitForBit) {
  const test::TemporaryFolder folder;
  for (const auto& [width, height] : {std::pair{1, 1}, {63, 5}, {65, 33}}) {
    Picture picture = random_picture(width, height);
    picture.layers[4].pixels[0] = 16777215;   // ids up to 2^24 - 1 are exact
    picture.layers[0].pixels[1] = 1e30f;      // and nothing is clamped
    picture.layers[0].pixels[2] = 0x1p-149f;  // not even the smallest number
    const std::string path = folder.file("picture.exr");
    write_picture(picture, path, {});
    const Picture back = read_picture(path);
    EXPECT_EQ(back.width, width);
    EXPECT_EQ(back.height, height);
    ASSERT_EQ(back.layers.size(), picture.layers.size());
    for (const Picture::Layer& layer : picture.layers) {
      const Picture::Layer* same = back.find(layer.name);
      ASSERT_NE(same, nullptr) << layer.name;
      EXPECT_EQ(same->channels, layer.channels);
      ASSERT_EQ(same->pixels.size(), layer.pixels.size());
      for (std::size_t k = 0; k < layer.pixels.size(); ++k)
        ASSERT_EQ(std::bit_cast<std::uint32_t>(same->pixels[k]), std::bit_cast<std::uint32_t>(layer.pixels[k]));
    }
  }
  EXPECT_THAT(folder.names(), ElementsAre("picture.exr")) << "no temporary file may stay";
}

TEST(PictureFile, ExrKeepsMetadata) {
  const test::TemporaryFolder folder;
  const Metadata metadata = {{"myrialux.version", "0.1.0"},
                             {"myrialux.method", "bamc"},
                             {"myrialux.command", "myrialux render 'a \"b\".xml' -D \xc3\xa9=1"},
                             {"Software", "Myrialux 0.1.0"}};
  write_picture(random_picture(4, 3), folder.file("a.exr"), metadata);
  Metadata back;
  read_picture(folder.file("a.exr"), &back);
  for (const auto& [key, value] : metadata) EXPECT_EQ(back[key], value) << key;
}

TEST(PictureFile, SamePictureGivesSameBytes) {
  const test::TemporaryFolder folder;
  for (const char* extension : {".exr", ".png", ".jpg", ".hdr"}) {
    write_picture(random_picture(33, 17), folder.file(std::string("a") + extension), {{"myrialux.seed", "1"}});
    write_picture(random_picture(33, 17), folder.file(std::string("b") + extension), {{"myrialux.seed", "1"}});
    EXPECT_EQ(folder.read(std::string("a") + extension), folder.read(std::string("b") + extension));
    EXPECT_FALSE(folder.read(std::string("a") + extension).empty());
  }
  Metadata header;
  read_picture(folder.file("a.exr"), &header);
  EXPECT_FALSE(header.contains("DateTime")) << "the hour of writing would tell the same picture apart";
}

TEST(PictureFile, NumberOfThreadsDoesNotChangeTheBytesAndNoThreadStays) {
  const test::TemporaryFolder folder;
  const Picture picture = random_picture(65, 333);  // several bands of blocks, the last of each not full
  for (const char* extension : {".exr", ".png", ".hdr"}) {
    std::string one;
    for (const int n_threads : {1, 2, 7}) {
      const ThreadScope threads(n_threads);
      write_picture(picture, folder.file(std::string("a") + extension), {});
      const std::string bytes = folder.read(std::string("a") + extension);
      if (n_threads == 1) one = bytes;
      EXPECT_EQ(bytes, one) << extension << " with " << n_threads << " threads";
      EXPECT_EQ(Imf::globalThreadCount(), 0) << "they may hang at exit";
    }
  }
}

TEST(PictureFile, PngHoldsTheSrgbCurveRounded) {
  const test::TemporaryFolder folder;
  const std::string path = folder.file("a.png");
  struct Case {
    float linear, exposure;
    int byte;
  };
  // Bytes computed from the curve's definition by hand (0.18 -> 0.46135 -> 117.6).
  for (const Case c : {Case{0, 0, 0},
                       {1, 0, 255},
                       {5, 0, 255},
                       {-1, 0, 0},
                       {0.18f, 0, 118},
                       {0.5f, 0, 188},
                       {0.001f, 0, 3},
                       {0.25f, 1, 188},
                       {1, -1, 188},
                       {0.18f, 2.4739312f, 255}}) {
    write_picture(beauty(3, 2, gray(c.linear)), path, {}, c.exposure);
    const Picture back = read_picture(path);
    for (const float v : back.find("")->pixels)
      EXPECT_EQ(static_cast<int>(std::lround(255 * encode_srgb(v))), c.byte) << c.linear << " at " << c.exposure;
  }
}

TEST(PictureFile, JpgAndHdrComeBackNearly) {
  const test::TemporaryFolder folder;
  const Picture flat = beauty(16, 16, {0.5f, 0.25f, 0.75f});
  write_picture(flat, folder.file("a.jpg"), {});
  write_picture(flat, folder.file("a.hdr"), {});
  const Picture jpg = read_picture(folder.file("a.jpg")), hdr = read_picture(folder.file("a.hdr"));
  for (std::size_t k = 0; k < 3 * 16 * 16; ++k) {
    const float truth = flat.layers[0].pixels[k];
    EXPECT_NEAR(jpg.find("")->pixels[k], truth, 0.02);         // 2 of 255 steps in the encoded value
    EXPECT_NEAR(hdr.find("")->pixels[k], truth, 0.75f / 128);  // 8 bits beside the pixel's exponent
  }
}

TEST(PictureFile, ColoursAreNotSwappedNorRowsFlipped) {
  const test::TemporaryFolder folder;
  Picture picture = beauty(2, 2, gray(0));
  picture.layers[0].pixels = {1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1};
  for (const char* name : {"a.exr", "a.png", "a.hdr"}) {
    write_picture(picture, folder.file(name), {});
    const Picture back = read_picture(folder.file(name));
    ASSERT_NE(back.find(""), nullptr);
    for (std::size_t k = 0; k < 12; ++k) EXPECT_NEAR(back.find("")->pixels[k], picture.layers[0].pixels[k], 1.0 / 128);
  }
}

TEST(PictureFile, NotANumberIsRefusedWithItsPlace) {
  const test::TemporaryFolder folder;
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()})
    for (const char* name : {"a.exr", "a.png"}) {
      Picture picture = random_picture(7, 5);
      picture.layers[2].pixels[3 * (4 * 7 + 6) + 1] = bad;
      const Error e = error_of([&] { write_picture(picture, folder.file(name), {}); });
      EXPECT_EQ(e.kind(), ErrorKind::input);
      EXPECT_THAT(e.what(), HasSubstr("pixel 6,4 of layer 'normal'"));
      EXPECT_THAT(e.what(), HasSubstr("channel Y"));
    }
  EXPECT_THAT(folder.names(), IsEmpty());
}

TEST(PictureFile, UnknownExtensionListsTheKnownOnes) {
  for (const char* path : {"a.bmp", "a", "a.exr/b"}) {
    const Error e = error_of([&] { picture_extension(path); });
    EXPECT_EQ(e.kind(), ErrorKind::usage);
    EXPECT_THAT(e.what(), HasSubstr(".exr .png .jpg .jpeg .hdr"));
  }
  EXPECT_EQ(picture_extension("Render.EXR"), ".exr");
}

TEST(PictureFile, MissingFolderIsNamedWithARemedy) {
  const test::TemporaryFolder folder;
  const Error e = error_of([&] { write_picture(random_picture(2, 2), folder.file("no/where/a.exr"), {}); });
  EXPECT_EQ(e.kind(), ErrorKind::output);
  EXPECT_THAT(e.what(), HasSubstr("does not exist; create it (mkdir -p"));
}

/// Lets no file grow beyond n_bytes while it lives, as a full disk would.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t n_bytes) : handler_(signal(SIGXFSZ, SIG_IGN)) {
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{n_bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit() {
    setrlimit(RLIMIT_FSIZE, &before_);
    signal(SIGXFSZ, handler_);
  }

 private:
  sighandler_t handler_;
  rlimit before_{};
};

TEST(PictureFile, FailingWriteLeavesWhatWasThere) {
  const test::TemporaryFolder folder;
  for (const std::string extension : {".exr", ".png", ".jpg", ".hdr"}) {
    folder.write("old" + extension, "before");
    const Picture picture = random_picture(64, 64);
    {
      const FileSizeLimit full(100);
      for (const char* stem : {"old", "new"})
        EXPECT_EQ(error_of([&] { write_picture(picture, folder.file(stem + extension), {}); }).kind(),
                  ErrorKind::output);
    }
    EXPECT_EQ(folder.read("old" + extension), "before");
    std::filesystem::remove(folder.file("old" + extension));
    EXPECT_THAT(folder.names(), IsEmpty()) << extension;
  }
}

TEST(PictureFile, WritingThroughALinkKeepsTheLink) {
  const test::TemporaryFolder folder;
  folder.write("real.exr", "before");
  std::filesystem::create_symlink("real.exr", folder.file("link.exr"));
  write_picture(random_picture(3, 3), folder.file("link.exr"), {});
  EXPECT_TRUE(std::filesystem::is_symlink(folder.file("link.exr")));
  EXPECT_EQ(read_picture(folder.file("real.exr")).width, 3);
}

TEST(PictureFile, UnreadableFilesAreNamed) {
  const test::TemporaryFolder folder;
  EXPECT_EQ(error_of([&] { read_picture(folder.file("none.exr")); }).kind(), ErrorKind::input);
  folder.write("broken.exr", "this is no picture");
  EXPECT_THAT(error_of([&] { read_picture(folder.file("broken.exr")); }).what(), HasSubstr("broken.exr"));
}

}  // namespace
}  // namespace myrialux
