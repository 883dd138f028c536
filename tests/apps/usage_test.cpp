// The command line: help, version, mistakes in usage, exit codes, and that nothing is left behind.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "apps/run_program.h"
#include "support/temporary_folder.h"

namespace myrialux {
namespace {

using test::Outcome;
using test::run_program;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::StartsWith;

class Usage : public testing::Test {
 protected:
  test::TemporaryFolder folder;
  std::string room = folder.write("room.xml", test::room_xml());
  /// Renders the room quickly with these arguments more.
  Outcome render(std::vector<std::string> more, const test::RunOptions& options = {}) const {
    std::vector<std::string> all = {"render", room, "--vpls", "200", "--clusters", "20", "--spp", "1"};
    all.insert(all.end(), more.begin(), more.end());
    return run_program(all, options);
  }
};

TEST_F(Usage, HelpTeachesOnStdout) {
  const Outcome top = run_program({"--help"});
  EXPECT_EQ(top.exit_code, 0);
  EXPECT_THAT(top.err, IsEmpty());
  for (const char* word : {"render", "info", "check", "lights", "compare", "bench", "Examples:"})
    EXPECT_THAT(top.out, HasSubstr(word));
  const Outcome render = run_program({"render", "--help"});
  EXPECT_EQ(render.exit_code, 0);
  for (const char* word : {"--method", "--spp", "default 4", "--visibility-error", "Default 0.005; methods: lbamc",
                           "degrees", "bamc.alpha=", "slice-lightcuts", "Examples:", "Exit codes"})
    EXPECT_THAT(render.out, HasSubstr(word));
  for (const char* absent : {"--resume", "--quality"})
    EXPECT_THAT(render.out + top.out, Not(HasSubstr(absent))) << "what does not exist must not be offered";
  for (const char* command : {"info", "check", "lights", "compare"}) {
    const Outcome help = run_program({command, "--help"});
    EXPECT_EQ(help.exit_code, 0);
    EXPECT_THAT(help.out, HasSubstr(std::string("myrialux ") + command));
  }
}

TEST_F(Usage, VersionIsOneLine) {
  const Outcome version = run_program({"--version"});
  EXPECT_EQ(version.exit_code, 0);
  EXPECT_THAT(version.out, StartsWith("myrialux " MYRIALUX_VERSION));
  EXPECT_EQ(version.out.find('\n'), version.out.size() - 1);
}

TEST_F(Usage, MistakesExitWith2AndSayWhatIsAllowed) {
  const std::string out = folder.file("a.png");
  struct Case {
    std::vector<std::string> arguments;
    std::string message;
  };
  const std::vector<Case> cases = {
      {{}, "Usage: myrialux"},
      {{"rendr", room}, "unknown command rendr; did you mean render?"},
      {{"render"}, "SCENE is required"},
      {{"render", room}, "--output is required"},
      {{"render", room, "-o", out, "--mehtod", "path"}, "unknown option --mehtod; did you mean --method?"},
      {{"render", room, "-o", out, "--mehtod=path"}, "did you mean --method?"},
      {{"render", room, "other.xml", "-o", out}, "one argument too many: other.xml"},
      {{"render", room, "-o", folder.file("a.bmp")}, ".exr .png .jpg .jpeg .hdr"},
      {{"render", room, "-o", out, "-o", out}, "named twice"},
      {{"render", room, "-o", out, "--stats", room}, "is read by this command"},
      {{"render", room, "-o", out, "--method", "bacm"}, "known: lbamc, bamc"},
      {{"render", room, "-o", out, "--size", "12"}, "WIDTHxHEIGHT"},
      {{"render", room, "-o", out, "--size", "0x5"}, "each from 1 to"},
      {{"render", room, "-o", out, "--spp", "0"}, "allowed is a whole number from 1"},
      {{"render", room, "-o", out, "--spp", "1.5"}, "got 1.5"},
      {{"render", room, "-o", out, "--vpls", "nan"}, "got nan"},
      {{"render", room, "-o", out, "--clusters", "0"}, "allowed is auto or a whole number from 1"},
      {{"render", room, "-o", out, "--clusters", "automatic"}, "got automatic"},
      {{"render", room, "-o", out, "--clusters", "auto", "--method", "lightcuts"},
       "method 'lightcuts' cannot choose the clusters of slices (--clusters auto); methods that can: lbamc, bamc"},
      {{"render", room, "-o", out, "--method", "bamc", "--visibility-error", "0.01"},
       "method 'bamc' cannot keep to an error of visibility (--visibility-error); methods that can: lbamc"},
      {{"render", room, "-o", out, "--method", "lbamc", "--visibility-error", "1.5"},
       "allowed is a number from 0 to 1"},
      {{"render", room, "-o", out, "--method", "lbamc", "--visibility-error", "-1"}, "got -1"},
      {{"render", room, "-o", out, "--max-depth", "0"}, "-1: no limit"},
      {{"render", room, "-o", out, "--clamp", "-1"}, "allowed is a number from 0"},
      {{"render", room, "-o", out, "--clamp", "0.1", "--clamp-distance", "1"}, "--clamp excludes --clamp-distance"},
      {{"render", room, "-o", out, "--filter", "gausian"}, "did you mean gaussian?"},
      {{"render", room, "-o", out, "--direct", "both"}, "vpl, sampled"},
      {{"render", room, "-o", out, "--aov", "normal,deph"}, "did you mean depth?"},
      {{"render", room, "-o", out, "--look-at", "1,2,3"}, "six or nine numbers"},
      {{"render", room, "-o", out, "--look-at", "1,2,3,1,2,3"}, "stands on the point"},
      {{"render", room, "-o", out, "--look-at", "0,1,0,0,2,0"}, "up is parallel"},
      {{"render", room, "-o", out, "--fov", "180"}, "degrees"},
      {{"render", room, "-o", out, "--aperture", "-1"}, "allowed is a number from 0"},
      {{"render", room, "-o", out, "--aperture", "0.1"}, "does not say which distance is sharp; add --focus-distance"},
      {{"render", room, "-o", out, "--focus-distance", "2"}, "a pinhole shows all distances sharp; add --aperture"},
      {{"render", room, "-o", out, "--memory-limit", "5Q"}, "for example 2G"},
      {{"render", room, "-o", out, "--progress", "loud"}, "auto, bar, plain, json, none"},
      {{"render", room, "-o", out, "--threads", "-1"}, "from 0"},
      {{"render", room, "-o", out, "-D", "bamc.alhpa=0.1"}, "-D bamc.alhpa: no such key; did you mean bamc.alpha?"},
      {{"render", room, "-o", out, "-D", "bamc.alpha"}, "KEY=VALUE"},
      {{"render", room, "-o", out, "-D", "bamc.alpha=7"}, "allowed is a number from 0 to 1"},
      {{"render", "chair.obj", "-o", out, "-D", "height=3"}, "only Mitsuba scenes"},
      {{"lights", room, "-o", folder.file("a.obj")}, "written as .ply"},
  };
  for (const Case& c : cases) {
    const Outcome o = run_program(c.arguments);
    EXPECT_EQ(o.exit_code, 2) << c.message << "\n" << o.err;
    EXPECT_THAT(o.err, HasSubstr(c.message));
    EXPECT_THAT(o.out, IsEmpty());
  }
  EXPECT_THAT(folder.names(), ElementsAre("room.xml")) << "nothing may be written";
}

TEST_F(Usage, UnwritableOutputExitsWith5BeforeAnyWork) {
  for (const std::string& path : {folder.file("none/a.png"), folder.file("room.xml/a.png")}) {
    const Outcome o = render({"-o", path});
    EXPECT_EQ(o.exit_code, 5) << o.err;
    EXPECT_THAT(o.err, Not(HasSubstr("load"))) << "the scene must not be read first";
  }
  EXPECT_EQ(render({"-o", folder.file("a.png"), "--stats", folder.file("none/a.json")}).exit_code, 5);
  EXPECT_THAT(folder.names(), ElementsAre("room.xml"));
}

TEST_F(Usage, MissingFilesExitWith3) {
  const Outcome o = run_program({"render", folder.file("no.xml"), "-o", folder.file("a.png")});
  EXPECT_EQ(o.exit_code, 3);
  EXPECT_THAT(o.err, HasSubstr("no.xml"));
  EXPECT_EQ(run_program({"info", folder.file("no.xml")}).exit_code, 3);
  EXPECT_EQ(run_program({"check", folder.file("no.xml")}).exit_code, 3);
  const Outcome lights = render({"-o", folder.file("a.png"), "--lights", folder.file("no.ply")});
  EXPECT_EQ(lights.exit_code, 3);
  EXPECT_THAT(lights.err, HasSubstr("myrialux lights"));
  EXPECT_THAT(folder.names(), ElementsAre("room.xml"));
}

TEST_F(Usage, MemoryLimitExitsWith4AndNamesSmallerSettings) {
  const Outcome o = render({"-o", folder.file("a.png"), "--memory-limit", "1M"});
  EXPECT_EQ(o.exit_code, 4);
  EXPECT_THAT(o.err, HasSubstr("--memory-limit"));
  EXPECT_THAT(folder.names(), ElementsAre("room.xml"));
}

TEST_F(Usage, ThreadsComeFromTheEnvironmentUnlessGiven) {
  const auto threads_of = [&](std::vector<std::string> more) {
    more.insert(more.end(), {"-o", folder.file("a.png"), "--stats", "-", "--progress", "none"});
    return render(more, {.environment = {"MYRIALUX_THREADS=3"}}).out;
  };
  EXPECT_THAT(threads_of({}), HasSubstr("\"threads\": 3,"));
  EXPECT_THAT(threads_of({"--threads", "1"}), HasSubstr("\"threads\": 1,"));
  EXPECT_EQ(render({"-o", folder.file("a.png")}, {.environment = {"MYRIALUX_THREADS=many"}}).exit_code, 2);
}

}  // namespace
}  // namespace myrialux
