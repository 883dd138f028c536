// The program at work: scenes told, checked and rendered, progress in all its forms, Ctrl-C.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "apps/run_program.h"
#include "myrialux/film/film.h"
#include "support/temporary_folder.h"

namespace myrialux {
namespace {

using nlohmann::json;
using test::Outcome;
using test::run_program;
using test::RunOptions;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::UnorderedElementsAre;

class Program : public testing::Test {
 protected:
  test::TemporaryFolder folder;
  std::string room = folder.write("room.xml", test::room_xml());

  Outcome render(std::vector<std::string> more, const RunOptions& options = {}) const {
    std::vector<std::string> all = {"render", room, "--vpls", "500", "--clusters", "50"};
    all.insert(all.end(), more.begin(), more.end());
    return run_program(all, options);
  }
};

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t n = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++n;
  return n;
}

TEST_F(Program, InfoTellsWhatIsInTheScene) {
  const Outcome o = run_program({"info", room, "--json"});
  ASSERT_EQ(o.exit_code, 0) << o.err;
  EXPECT_THAT(o.err, IsEmpty());
  const json j = json::parse(o.out);
  EXPECT_EQ(j["shapes"], 3);
  EXPECT_EQ(j["triangles"], 6);
  EXPECT_EQ(j["lights"]["area"], 1);
  EXPECT_GE(j["materials"]["diffuse"], 1);
  EXPECT_EQ(j["film"]["width"], 24);
  EXPECT_EQ(j["film"]["height"], 16);
  EXPECT_EQ(j["max_depth"], 4);
  EXPECT_NEAR(j["camera"]["origin"][2].get<double>(), 4, 1e-6);
  EXPECT_NEAR(j["camera"]["direction"][2].get<double>(), -1, 1e-6);
  EXPECT_NEAR(j["camera"]["fov_x_deg"].get<double>(), 60, 1e-4);
  EXPECT_NEAR(j["bounds"]["upper"][1].get<double>(), 2, 1e-5);
  EXPECT_TRUE(j["warnings"].is_array());
  const Outcome words = run_program({"info", room});
  EXPECT_EQ(words.exit_code, 0);
  EXPECT_THAT(words.out, HasSubstr("24x16 pixels"));
}

TEST_F(Program, CheckPassesAGoodScene) {
  const Outcome o = run_program({"check", room});
  EXPECT_EQ(o.exit_code, 0) << o.err;
  EXPECT_THAT(o.out, HasSubstr("no errors"));
}

TEST_F(Program, CheckListsAllMistakesWithTheirPlaces) {
  const std::string broken = folder.write("broken.xml", test::room_xml("<bsdf type=\"difuse\" id=\"x\"/>\n"
                                                                       "<shape type=\"obj\"><string name=\"filename\" "
                                                                       "value=\"none.obj\"/></shape>\n"));
  const Outcome o = run_program({"check", broken});
  EXPECT_EQ(o.exit_code, 3);
  EXPECT_THAT(o.err, HasSubstr("broken.xml:11:"));
  EXPECT_THAT(o.err, HasSubstr("diffuse")) << "the nearest name helps";
  EXPECT_THAT(o.err, HasSubstr("broken.xml:12:"));
  EXPECT_THAT(o.err, HasSubstr("none.obj"));
  const Outcome rendered = run_program({"render", broken, "-o", folder.file("a.exr")});
  EXPECT_EQ(rendered.exit_code, 3);
  EXPECT_THAT(folder.names(), UnorderedElementsAre("room.xml", "broken.xml")) << "no picture of a broken scene";
}

TEST_F(Program, ClustersAreChosenOnceAndToldEverywhere) {
  const std::string a = folder.file("a.exr"), b = folder.file("b.exr"), stats = folder.file("a.json");
  const Outcome o = run_program({"render", room, "-o", a, "--stats", stats, "--method", "lbamc", "--clusters", "auto",
                                 "--vpls", "3000", "--passes", "2", "--progress", "plain"});
  ASSERT_EQ(o.exit_code, 0) << o.err;
  EXPECT_EQ(count(o.err, "clusters a slice: a pass errs by"), 1u) << "the first pass chooses for all";
  const json chosen = json::parse(folder.read("a.json"))["clusters_auto"];
  EXPECT_GE(chosen["chosen"], 64);
  EXPECT_GT(chosen["light_set_error"], 0);
  EXPECT_GT(chosen["cluster_error"], 0);
  EXPECT_GT(chosen["visibility_error"], 0);
  EXPECT_THAT(o.err, HasSubstr(chosen["chosen"].dump() + " clusters a slice"));
  Metadata header;
  const Picture picture = read_picture(a, &header);
  EXPECT_EQ(header["myrialux.clusters"], "auto");
  EXPECT_EQ(header["myrialux.clusters_chosen"], chosen["chosen"].dump());

  // The number that the header tells gives the same picture.
  ASSERT_EQ(run_program({"render", room, "-o", b, "--method", "lbamc", "--clusters", header["myrialux.clusters_chosen"],
                         "--vpls", "3000", "--passes", "2", "--progress", "none"})
                .exit_code,
            0);
  EXPECT_EQ(picture.find("")->pixels, read_picture(b).find("")->pixels);
}

TEST_F(Program, RenderWritesPicturesAndStatsAndNamesThemLast) {
  const std::string exr = folder.file("a.exr"), png = folder.file("a.png"), stats = folder.file("a.json");
  const Outcome o = render({"-o", exr, "-o", png, "--stats", stats, "--size", "20x10", "--seed", "5"});
  ASSERT_EQ(o.exit_code, 0) << o.err;
  EXPECT_THAT(o.out, IsEmpty()) << "stdout is for data";
  EXPECT_TRUE(o.err.ends_with("wrote " + exr + "\nwrote " + png + "\nwrote " + stats + "\n")) << o.err;
  EXPECT_THAT(o.err, HasSubstr("time: load"));
  EXPECT_THAT(o.err, HasSubstr("visibility: "));
  EXPECT_THAT(folder.names(), UnorderedElementsAre("room.xml", "a.exr", "a.png", "a.json"));

  Metadata header;
  const Picture picture = read_picture(exr, &header);
  EXPECT_EQ(picture.width, 20);
  EXPECT_EQ(picture.height, 10);
  for (const char* layer : {"", "albedo", "normal", "depth", "slice", "cut", "visibility"})
    EXPECT_NE(picture.find(layer), nullptr) << layer;
  EXPECT_EQ(picture.find("error"), nullptr) << "so few slices are traced whole";
  EXPECT_EQ(header["myrialux.seed"], "5");
  EXPECT_THAT(header["myrialux.command"], HasSubstr("--size 20x10"));
  double sum = 0;
  for (const float v : picture.find("")->pixels) sum += v;
  EXPECT_GT(sum, 0) << "the room is lit";

  const json j = json::parse(folder.read("a.json"));
  EXPECT_EQ(j["method"], "lbamc");
  EXPECT_EQ(j["seed"], 5);
  EXPECT_GT(j["receivers"], 0);
  EXPECT_GT(j["time_s"]["load"], 0);
  EXPECT_GE(j["time_s"]["total"], j["time_s"]["load"]);
  EXPECT_GT(j["memory_bytes"]["peak_rss"], 1 << 20);
}

TEST_F(Program, ErrorOfVisibilityIsKeptToAndToldEverywhere) {
  const std::string exr = folder.file("a.exr"), stats = folder.file("a.json");
  const auto rendered = [&](const std::vector<std::string>& more) {
    std::vector<std::string> all = {"render", room, "-o", exr, "--stats", stats, "--method", "lbamc"};
    for (const char* word : {"--size", "96x64", "--spp", "2", "--vpls", "3000", "--clusters", "100", "--passes", "2",
                             "-D", "slices.rows=256"})
      all.push_back(word);
    all.insert(all.end(), more.begin(), more.end());
    const Outcome o = run_program(all);
    EXPECT_EQ(o.exit_code, 0) << o.err;
    return o.err;
  };
  const std::string told = rendered({"--visibility-error", "0.01"});
  EXPECT_THAT(told, HasSubstr(" traced ("));
  EXPECT_THAT(told, HasSubstr("; error by the others "));
  EXPECT_THAT(told, HasSubstr("% of all bits wrong"));
  Metadata header;
  Picture picture = read_picture(exr, &header);
  EXPECT_EQ(header["myrialux.visibility_error"], "0.01");
  const json j = json::parse(folder.read("a.json")), meter = j["visibility"]["meter"];
  EXPECT_EQ(j["parameters"]["myrialux.visibility_error"], "0.01");
  EXPECT_GT(meter["rays"], 0);
  EXPECT_LE(meter["pilot_error"], 0.01);
  EXPECT_LE(meter["error"]["low"], meter["error"]["estimate"]);
  EXPECT_LE(meter["error"]["estimate"], meter["error"]["high"]);
  EXPECT_EQ(meter["slices"], j["slices"]);
  const Picture::Layer* error = picture.find("error");
  ASSERT_NE(error, nullptr);
  EXPECT_THAT(error->channels, ElementsAre("visibility"));
  EXPECT_EQ(error->pixels.size(), 96u * 64u);
  EXPECT_THAT(error->pixels, testing::Each(testing::Ge(0.0f)));

  rendered({});
  picture = read_picture(exr, &header);
  EXPECT_EQ(header["myrialux.visibility_error"], "0.005") << "the default is told, too";
  rendered({"--aov", "slice,error"});
  EXPECT_EQ(read_picture(exr).layers.size(), 3u);

  EXPECT_THAT(rendered({"--visibility-error", "0"}), Not(HasSubstr("error by the others")));
  EXPECT_EQ(read_picture(exr).find("error"), nullptr) << "nothing was copied";
  const json all = json::parse(folder.read("a.json"))["visibility"];
  EXPECT_TRUE(all["meter"].is_null());
  EXPECT_EQ(all["fraction"], 1);
}

TEST_F(Program, AllMethodsRender) {
  for (const char* method : {"bamc", "slice-lightcuts", "brute-force", "path"}) {
    const Outcome o = render({"-o", folder.file("a.exr"), "--method", method, "--spp", "2"});
    EXPECT_EQ(o.exit_code, 0) << method << "\n" << o.err;
  }
}

TEST_F(Program, ExposureAndCameraReachThePicture) {
  const auto mean = [&](std::vector<std::string> more) {
    more.insert(more.end(), {"-o", folder.file("a.png"), "--progress", "none"});
    const Outcome o = render(more);
    EXPECT_EQ(o.exit_code, 0) << o.err;
    EXPECT_THAT(o.err, IsEmpty()) << "none means none";
    const Picture picture = read_picture(folder.file("a.png"));
    double sum = 0;
    for (const float v : picture.find("")->pixels) sum += v;
    return sum;
  };
  const double plain = mean({});
  EXPECT_GT(mean({"--exposure", "1"}), 1.3 * plain);
  EXPECT_LT(mean({"--exposure", "-2"}), 0.5 * plain);
  EXPECT_EQ(mean({"--look-at", "0,1,4,0,1,8"}), 0) << "there is nothing behind the camera";
  EXPECT_LT(mean({"--fov", "20"}), plain) << "the lamp is out of sight";
}

TEST_F(Program, LensMotionAndClustersAreToldAsTheyWereUsed) {
  std::string text = test::room_xml();
  const auto replace = [&](const std::string& old, const std::string& by) {
    text.replace(text.find(old), old.size(), by);
  };
  replace("<sensor type=\"perspective\">",
          "<sensor type=\"thinlens\"><float name=\"aperture_radius\" value=\"0.25\"/><float name=\"focus_distance\" "
          "value=\"4\"/><float name=\"shutter_close\" value=\"2\"/>");
  replace("<transform name=\"to_world\">", "<animation name=\"to_world\"><transform time=\"0\">");
  replace("</transform>",
          "</transform><transform time=\"2\"><rotate y=\"1\" angle=\"180\"/><translate x=\"1\" y=\"1\" z=\"4\"/>"
          "</transform></animation>");
  const std::string scene = folder.write("moving.xml", text);
  const json camera = json::parse(run_program({"info", scene, "--json"}).out)["camera"];
  EXPECT_EQ(camera["aperture_radius"], 0.25);
  EXPECT_EQ(camera["focus_distance"], 4);
  EXPECT_EQ(camera["keyframes"], 2);
  EXPECT_EQ(camera["shutter"], json({0, 2}));
  EXPECT_NEAR(camera["origin"][0].get<double>(), 0.5, 1e-6);

  const auto parameters = [&](const std::vector<std::string>& more) {
    std::vector<std::string> all = {"render",     scene,  "-o",      folder.file("a.exr"),
                                    "--spp",      "2",    "--vpls",  "100",
                                    "--progress", "none", "--stats", "-"};
    all.insert(all.end(), more.begin(), more.end());
    const Outcome o = run_program(all);
    EXPECT_EQ(o.exit_code, 0) << o.err;
    return json::parse(o.out)["parameters"];
  };
  const json moving = parameters({"--method", "mdlc"});
  EXPECT_EQ(moving["myrialux.aperture_radius"], "0.25");
  EXPECT_EQ(moving["myrialux.focus_distance"], "4");
  EXPECT_EQ(moving["myrialux.shutter"], "0 2");
  EXPECT_THAT(moving["myrialux.camera_motion"].get<std::string>(), testing::StartsWith("0: "));
  EXPECT_EQ(moving["myrialux.clusters"], "10000");
  const json placed = parameters({"--look-at", "0,1,4,0,1,0", "--aperture", "0", "--method", "lightcuts"});
  EXPECT_FALSE(placed.contains("myrialux.aperture_radius"));
  EXPECT_FALSE(placed.contains("myrialux.camera_motion")) << "a camera that is placed stands still";
  EXPECT_EQ(placed["myrialux.clusters"], "1000");
  EXPECT_EQ(parameters({"--method", "mdlc", "--clusters", "77"})["myrialux.clusters"], "77");
}

TEST_F(Program, StoredLightsGiveTheSamePicture) {
  const std::string ply = folder.file("lights.ply");
  for (const bool ascii : {false, true}) {
    std::vector<std::string> store = {"lights", room, "-o", ply, "--vpls", "500"};
    if (ascii) store.push_back("--ascii");
    const Outcome stored = run_program(store);
    ASSERT_EQ(stored.exit_code, 0) << stored.err;
    EXPECT_THAT(stored.err, HasSubstr("wrote " + ply));
    ASSERT_EQ(render({"-o", folder.file("a.exr"), "--direct", "vpl"}).exit_code, 0);
    ASSERT_EQ(render({"-o", folder.file("b.exr"), "--direct", "vpl", "--lights", ply}).exit_code, 0);
    const Picture a = read_picture(folder.file("a.exr")), b = read_picture(folder.file("b.exr"));
    EXPECT_EQ(a.find("")->pixels, b.find("")->pixels);
  }
}

TEST_F(Program, DefinitionsReachSceneAndRenderer) {
  const std::string scene = folder.write(
      "defined.xml", test::room_xml("<default name=\"glow\" value=\"1\"/>\n<emitter type=\"constant\"><rgb "
                                    "name=\"radiance\" value=\"$glow\"/></emitter>\n"));
  const auto depth_free_mean = [&](const std::string& glow) {
    const Outcome o = run_program({"render", scene, "-o", folder.file("a.exr"), "--vpls", "200", "--clusters", "20",
                                   "-D", "glow=" + glow, "-Dbamc.alpha=0.5", "--look-at", "0,1,9,0,1,99"});
    EXPECT_EQ(o.exit_code, 0) << o.err;
    Metadata header;
    const float pixel = read_picture(folder.file("a.exr"), &header).find("")->pixels[0];
    EXPECT_EQ(header["myrialux.bamc.alpha"], "0.5");
    return pixel;
  };
  EXPECT_FLOAT_EQ(depth_free_mean("0.25"), 0.25f);
  EXPECT_FLOAT_EQ(depth_free_mean("3"), 3);
}

TEST_F(Program, JsonProgressIsOneObjectALine) {
  const Outcome o = render({"-o", folder.file("a.png"), "--progress", "json"});
  ASSERT_EQ(o.exit_code, 0) << o.err;
  std::istringstream lines(o.err);
  std::vector<std::string> events;
  for (std::string line; std::getline(lines, line);) {
    const json j = json::parse(line);
    events.push_back(j.at("event"));
    if (events.back() == "done") {
      EXPECT_THAT(j.at("outputs"), ElementsAre(folder.file("a.png")));
    } else if (events.back() == "stage_end") {
      EXPECT_GE(j.at("elapsed_s"), 0);
    }
  }
  ASSERT_GT(events.size(), 4u);
  EXPECT_EQ(events.front(), "stage");
  EXPECT_EQ(events.back(), "done");
  const Outcome failed =
      run_program({"render", folder.file("no.xml"), "-o", folder.file("b.png"), "--progress", "json"});
  EXPECT_EQ(failed.exit_code, 3);
  const std::string last = failed.err.substr(failed.err.rfind('{'));
  EXPECT_EQ(json::parse(last)["exit_code"], 3);
}

TEST_F(Program, TerminalGetsOneLineAStage) {
  const Outcome o = render({"-o", folder.file("a.png")}, {.terminal = true});
  ASSERT_EQ(o.exit_code, 0) << o.err;
  EXPECT_THAT(o.err, HasSubstr("\r\x1b[K")) << "the running line is replaced";
  for (const char* stage : {"\x1b[Kload ", "\x1b[Kreceivers ", "\x1b[Kslices "})
    EXPECT_GE(count(o.err, stage), 1u) << stage << o.err;
  const Outcome plain =
      render({"-o", folder.file("a.png"), "--progress", "plain"}, {.environment = {"NO_COLOR=1"}, .terminal = true});
  EXPECT_THAT(plain.err, Not(HasSubstr("\x1b")));
}

TEST_F(Program, EqualWarningsAreToldOnce) {
  std::string extra;
  for (int k = 0; k < 5; ++k) extra += "<bsdf type=\"diffuse\"><float name=\"nonsense\" value=\"1\"/></bsdf>\n";
  const std::string scene = folder.write("warned.xml", test::room_xml(extra));
  const Outcome o = run_program({"render", scene, "-o", folder.file("a.png"), "--vpls", "200", "--clusters", "20"});
  ASSERT_EQ(o.exit_code, 0) << o.err;
  EXPECT_EQ(count(o.err, "nonsense"), 1u) << o.err;
  EXPECT_THAT(o.err, HasSubstr("(5 times in all)"));
  EXPECT_THAT(o.err, HasSubstr("warned.xml:11:"));
  EXPECT_EQ(run_program({"render", scene, "-o", folder.file("b.png"), "--strict"}).exit_code, 3);
}

TEST_F(Program, InterruptLeavesNoPictureAndExitsWith130) {
  const auto begin = std::chrono::steady_clock::now();
  const Outcome o = render({"-o", folder.file("a.exr"), "--size", "512x512", "--passes", "10000", "--progress", "json"},
                           {.signal_after = "receivers"});
  EXPECT_EQ(o.exit_code, 130) << o.err;
  EXPECT_THAT(o.err, HasSubstr("interrupted; nothing was written"));
  EXPECT_THAT(folder.names(), ElementsAre("room.xml"));
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(30));
}

}  // namespace
}  // namespace myrialux
