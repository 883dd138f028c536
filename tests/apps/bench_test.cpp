// myrialux bench: results of a small bench, going on after an interruption, and what it refuses.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "apps/run_program.h"
#include "support/temporary_folder.h"

namespace myrialux {
namespace {

using nlohmann::json;
using test::Outcome;
using test::run_program;
using testing::HasSubstr;

const std::string kRoom = MYRIALUX_SOURCE_DIR "/scenes/cornell-box/scene.xml";

std::string text_of(const std::string& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}
std::size_t lines_of(const std::string& path) {
  const std::string text = text_of(path);
  return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

class BenchCommand : public testing::Test {
 protected:
  test::TemporaryFolder folder;
  std::string out = folder.file("bench");
  Outcome bench(std::vector<std::string> more = {}) const {
    std::vector<std::string> words = {"bench",     kRoom,   "-o",        out,   "--size",     "24x24",
                                      "--spp",     "1",     "--vpls",    "400", "--clusters", "60",
                                      "--budgets", "1,0.5", "--repeats", "2",   "--no-page"};
    words.insert(words.end(), more.begin(), more.end());
    return run_program(words);
  }
};

TEST_F(BenchCommand, EveryMethodAtEveryBudgetIsHeldAgainstBruteForce) {
  const Outcome o = bench();
  ASSERT_EQ(o.exit_code, 0) << o.err;
  const json results = json::parse(text_of(out + "/results.json"));
  EXPECT_EQ(results["config"]["size"], "24x24");
  ASSERT_EQ(results["results"].size(), 5u);
  EXPECT_EQ(results["results"][0]["method"], "brute-force");
  EXPECT_TRUE(results["results"][0]["relative_rmse"].is_null());
  std::map<std::string, std::map<double, json>> by_method;
  for (const json& r : results["results"]) by_method[r["method"]][r["budget"]] = r;
  for (const char* method : {"slice-lightcuts", "bamc"}) {
    const json &half = by_method[method][0.5], &whole = by_method[method][1];
    EXPECT_EQ(half["knob"], "clusters=30") << method;
    EXPECT_EQ(whole["repeats"], 2);
    EXPECT_GT(half["relative_rmse"], whole["relative_rmse"]) << method;
    EXPECT_GE(whole["seconds_most"], whole["seconds_least"]);
    EXPECT_GT(whole["cpu_seconds"], 0);
    EXPECT_TRUE(std::filesystem::exists(out + "/" + std::string(whole["picture"])));
  }
  // One slice, so no guess and no pilot: the same entries, all of them traced by one of the two.
  EXPECT_EQ(by_method["slice-lightcuts"][1]["traced"], by_method["slice-lightcuts"][1]["entries"]);
  EXPECT_EQ(by_method["bamc"][1]["entries"], by_method["slice-lightcuts"][1]["entries"]);
  EXPECT_EQ(lines_of(out + "/results.csv"), 6u);
  EXPECT_EQ(lines_of(out + "/runs.jsonl"), 9u);
}

TEST_F(BenchCommand, GoesOnWhereItStopped) {
  ASSERT_EQ(bench().exit_code, 0);
  const std::string runs = text_of(out + "/runs.jsonl"), before = text_of(out + "/results.json");
  const Outcome again = bench();
  EXPECT_EQ(again.exit_code, 0) << again.err;
  EXPECT_EQ(text_of(out + "/runs.jsonl"), runs) << "nothing was left to do";

  // The last three runs are lost, one in the middle of its line.
  std::size_t end = runs.size();
  for (int k = 0; k < 4; ++k) end = runs.rfind('\n', end - 1);
  folder.write("bench/runs.jsonl", runs.substr(0, end + 20));
  EXPECT_EQ(bench().exit_code, 0);
  EXPECT_EQ(lines_of(out + "/runs.jsonl"), 9u);
  const json old_results = json::parse(before), results = json::parse(text_of(out + "/results.json"));
  for (std::size_t k = 0; k < 5; ++k)
    EXPECT_EQ(results["results"][k]["relative_rmse"], old_results["results"][k]["relative_rmse"]);
}

TEST_F(BenchCommand, RefusesAFolderWithOtherSettings) {
  ASSERT_EQ(bench().exit_code, 0);
  const Outcome o = bench({"--seed", "3"});
  EXPECT_EQ(o.exit_code, 2);
  EXPECT_THAT(o.err, HasSubstr("holds a bench with other settings: seed 3 (there: 0); name another folder"));
}

TEST_F(BenchCommand, RefusesWhatCannotBeCompared) {
  for (const auto& [words, message] : std::vector<std::pair<std::vector<std::string>, std::string>>{
           {{"--methods", "bamc,path"}, "path has no virtual lights to be compared on; leave it out"},
           {{"--methods", "brute-force"}, "brute-force is the reference of every bench; leave it out"},
           {{"--methods", "bmac"}, "unknown method 'bmac'"}}) {
    const Outcome o = bench(words);
    EXPECT_EQ(o.exit_code, 2) << o.err;
    EXPECT_THAT(o.err, HasSubstr(message));
    EXPECT_FALSE(std::filesystem::exists(out)) << "nothing is made before everything is checked";
  }
  const Outcome o = run_program({"bench", kRoom, "-o", out, "--budgets", "1,0"});
  EXPECT_EQ(o.exit_code, 2);
  EXPECT_THAT(o.err, HasSubstr("--budgets 1,0: allowed are numbers above 0 by commas"));
}

TEST_F(BenchCommand, ABrokenRecordIsNamed) {
  ASSERT_EQ(bench().exit_code, 0);
  folder.write("bench/runs.jsonl", "{\"scene\": 3}\n");
  const Outcome o = bench();
  EXPECT_EQ(o.exit_code, 3);
  EXPECT_THAT(o.err, HasSubstr("runs.jsonl:1: no record of a run"));
}

}  // namespace
}  // namespace myrialux
