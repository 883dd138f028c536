// myrialux compare: table, JSON, mistakes, and what it says when Python or its packages are missing.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "apps/run_program.h"
#include "support/picture_files.h"
#include "support/temporary_folder.h"

namespace myrialux {
namespace {

using nlohmann::json;
using test::Outcome;
using test::run_program;
using test::RunOptions;
using testing::AllOf;
using testing::ContainsRegex;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

class CompareCommand : public testing::Test {
 protected:
  test::TemporaryFolder folder;
  std::string truth = test::write_gray(folder.file("truth.exr"), 4, 3, 2),
              a = test::write_gray(folder.file("a.exr"), 4, 3, 3),
              b = test::write_gray(folder.file("b.exr"), 4, 3, 2.5f);
  std::size_t n_files = folder.names().size();

  /// A program that stands in for Python.
  std::string fake_python(const std::string& script) const {
    const std::string path = folder.write("python", "#!/bin/sh\n" + script);
    chmod(path.c_str(), 0755);
    return "MYRIALUX_PYTHON=" + path;
  }
};

TEST_F(CompareCommand, TablePutsTheSmallestErrorFirst) {
  const Outcome o = run_program({"compare", truth, a, b});
  ASSERT_EQ(o.exit_code, 0) << o.err;
  EXPECT_THAT(o.out, HasSubstr("reference " + truth + ": 4x3 pixels, mean luminance 2\n"));
  EXPECT_THAT(o.out, ContainsRegex("\n +b +a\nluminance\n"));
  EXPECT_THAT(o.out, ContainsRegex("  relative RMSE +25\\.0 % +50\\.0 %\n"));
  EXPECT_THAT(o.out, ContainsRegex("  mean G / reference +1\\.250 +1\\.500\n"));
  EXPECT_THAT(o.out, Not(HasSubstr("FLIP"))) << "not asked for";
}

TEST_F(CompareCommand, ManyPicturesGoOnBelow) {
  std::vector<std::string> words = {"compare", truth};
  for (int k = 0; k < 12; ++k)
    words.push_back(test::write_gray(folder.file("picture-" + std::to_string(k) + ".exr"), 4, 3, 2 + 0.1f * float(k)));
  const Outcome o = run_program(words);
  ASSERT_EQ(o.exit_code, 0) << o.err;
  std::istringstream lines(o.out);
  std::size_t n_tables = 0;
  for (std::string line; std::getline(lines, line);) {
    if (line == "luminance") ++n_tables;
    EXPECT_TRUE(line.starts_with("reference") || line.size() <= 100) << line;
  }
  EXPECT_EQ(n_tables, 2u) << "six columns of 12 beside 22 of names";
  EXPECT_THAT(o.out, HasSubstr("picture-11"));
}

TEST_F(CompareCommand, JsonGoesToStdoutAlone) {
  const Outcome o = run_program({"compare", truth, a, "--json", "--progress", "none"});
  ASSERT_EQ(o.exit_code, 0) << o.err;
  EXPECT_THAT(o.err, IsEmpty());
  const json j = json::parse(o.out);
  EXPECT_EQ(j["reference"]["path"], truth);
  EXPECT_NEAR(j["images"][0]["rgb"]["relative_rmse"].get<double>(), 0.5, 1e-6);
  EXPECT_EQ(j["images"][0]["header"]["myrialux.method"], "test");
}

TEST_F(CompareCommand, RegionAndExposureAreApplied) {
  const Outcome o = run_program({"compare", truth, a, "--json", "--region", "1,0,2,3", "--exposure", "-3"});
  ASSERT_EQ(o.exit_code, 0) << o.err;
  const json j = json::parse(o.out);
  EXPECT_EQ(j["region"], json({1, 0, 2, 3}));
  EXPECT_EQ(j["exposure"], -3);
  EXPECT_TRUE(j["images"][0]["rgb"]["psnr_db"].is_number()) << "both white without the exposure";
}

TEST_F(CompareCommand, MistakesInUsageExitWith2) {
  struct Case {
    std::vector<std::string> arguments;
    std::string message;
  };
  const std::vector<Case> cases = {
      {{}, "REF is required"},
      {{truth}, "IMAGE is required"},
      {{truth, a, a}, "named twice"},
      {{truth, a, "-o", folder.file("page.pdf")}, "written as .html"},
      {{truth, a, "--region", "1,2,3"}, "four whole numbers"},
      {{truth, a, "--region", "0,0,0,1"}, "four whole numbers"},
      {{truth, a, "--region", "0.5,0,1,1"}, "four whole numbers"},
      {{truth, a, "--exposure", "bright"}, "stops"},
      {{truth, a, "--jsno"}, "did you mean --json?"},
  };
  for (const Case& c : cases) {
    std::vector<std::string> words = {"compare"};
    words.insert(words.end(), c.arguments.begin(), c.arguments.end());
    const Outcome o = run_program(words);
    EXPECT_EQ(o.exit_code, 2) << c.message << "\n" << o.err;
    EXPECT_THAT(o.err, HasSubstr(c.message));
    EXPECT_THAT(o.out, IsEmpty());
  }
  EXPECT_EQ(folder.names().size(), n_files);
}

TEST_F(CompareCommand, BadPicturesExitWith3AndAreAllTold) {
  const std::string nan = test::write_with_nan(folder.file("nan.exr"), 4, 3, 2);
  const Outcome o =
      run_program({"compare", truth, folder.file("none.exr"), nan, test::write_gray(folder.file("c.exr"), 9, 9, 1)});
  EXPECT_EQ(o.exit_code, 3);
  EXPECT_THAT(o.err, AllOf(HasSubstr("none.exr"), HasSubstr("nan.exr"), HasSubstr("c.exr: has 9x9 pixels")));
  EXPECT_EQ(run_program({"compare", truth, a, "--region", "2,2,9,9"}).exit_code, 3);
}

TEST_F(CompareCommand, MissingPackagesExitWith5AndTheCommandThatInstallsThem) {
  const std::string page = folder.file("page.html");
  const RunOptions lacking{.environment = {fake_python("echo plotly, numpy; exit 69\n")}};
  const Outcome o = run_program({"compare", truth, a, "-o", page}, lacking);
  EXPECT_EQ(o.exit_code, 5);
  EXPECT_THAT(o.err, HasSubstr("page.html: "));
  EXPECT_THAT(o.err, HasSubstr("lacks the packages plotly, numpy; install them with: " + folder.file("python") +
                               " -m pip install -r "));
  EXPECT_EQ(run_program({"compare", truth, a, "--flip"}, lacking).exit_code, 5);
  EXPECT_EQ(run_program({"compare", truth, a}, lacking).exit_code, 0) << "the numbers need no Python";

  const RunOptions absent{.environment = {"MYRIALUX_PYTHON=" + folder.file("no-python")}};
  const Outcome none = run_program({"compare", truth, a, "-o", page}, absent);
  EXPECT_EQ(none.exit_code, 5);
  EXPECT_THAT(none.err, AllOf(HasSubstr("no-python"), HasSubstr("MYRIALUX_PYTHON names it")));

  const RunOptions failing{.environment = {fake_python("echo some reason >&2; exit 1\n")}};
  EXPECT_THAT(run_program({"compare", truth, a, "-o", page}, failing).err,
              AllOf(HasSubstr("ended with code 1"), HasSubstr("some reason")));
  EXPECT_FALSE(std::filesystem::exists(page));
}

TEST_F(CompareCommand, UnwritablePageExitsWith5BeforeAnyWork) {
  const Outcome o = run_program({"compare", folder.file("none.exr"), a, "-o", folder.file("none/page.html")});
  EXPECT_EQ(o.exit_code, 5);
  EXPECT_THAT(o.err, HasSubstr("does not exist"));
}

}  // namespace
}  // namespace myrialux
