// myrialux compare: how far pictures are from a reference, as a table, as JSON or as an HTML page.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "commands.h"
#include "comparison_page.h"
#include "myrialux/base/output_file.h"
#include "values.h"
#include "words.h"

namespace myrialux::app {
namespace {

struct CompareOptions {
  std::string reference, page, region, progress = "auto";
  std::vector<std::string> images;
  double exposure = 0;
  bool as_json = false, flip = false;
};

void add_arguments(CLI::App& command, CompareOptions& o);
std::optional<Region> parse_region(const std::string& text);
/// Everything that can be refused before the pictures are read.
void check(const CompareOptions& o);
std::string table(const Comparison& comparison);
std::string footer();

void run(const CompareOptions& o, Session& session) {
  session.reporter = make_reporter(o.progress);
  Reporter& reporter = *session.reporter;
  const ComparisonOptions options{.exposure = o.exposure, .region = parse_region(o.region)};
  check(o);
  reporter.stage("compare", 0, "");
  Comparison comparison = compare_pictures(o.reference, o.images, options);
  if (o.flip || !o.page.empty()) {
    reporter.stage(o.page.empty() ? "flip" : "flip, page", 0, "");
    add_flip_and_page(comparison, o.page);
  }
  reporter.end_stage();
  if (o.as_json)
    fmt::print("{}", to_json(comparison));
  else if (o.page.empty() || o.flip)
    fmt::print("{}", table(comparison));
  if (!o.page.empty()) reporter.done({}, {absolute_path(o.page)});
}

}  // namespace

void add_compare(CLI::App& app, Session& session) {
  CLI::App& command = *app.add_subcommand("compare", "Tell how far pictures are from a reference");
  auto options = std::make_shared<CompareOptions>();
  add_arguments(command, *options);
  command.footer(footer);
  command.callback([options, &session] { session.run = [options, &session] { run(*options, session); }; });
}

namespace {

void add_arguments(CLI::App& c, CompareOptions& o) {
  c.add_option("REF", o.reference, "The picture taken as the truth")->required()->option_text(" ");
  c.add_option("IMAGE", o.images, "Pictures of the same size: .exr .hdr (linear)\nor .png .jpg (sRGB curve undone)")
      ->required()
      ->option_text("...");
  c.add_option("-o,--output", o.page, "Write an HTML page: pictures with slider, error\nmaps, plots, tables")
      ->option_text("REPORT.html");
  c.add_flag("--json", o.as_json, "Print JSON instead of a table");
  c.add_flag("--flip", o.flip, "Also evaluate FLIP (-o always does); needs\nPython");
  c.add_option("--exposure", o.exposure, "Stops added where pictures are shown: page,\nPSNR, FLIP as shown; default 0")
      ->check(number(-100, 100, "stops"))
      ->option_text("STOPS");
  c.add_option("--region", o.region, "Compare only x,y,width,height; pixels from the\ntop left")
      ->option_text("X,Y,W,H");
  c.add_option("--progress", o.progress, "auto, bar, plain, json or none; on stderr")
      ->check(one_of({"auto", "bar", "plain", "json", "none"}))
      ->option_text("KIND");
}

std::optional<Region> parse_region(const std::string& text) {
  if (text.empty()) return {};
  const std::string allowed = "four whole numbers x,y,width,height, for example 100,50,64,64";
  std::vector<int> v;
  for (const float value : parse_floats("--region", text, {4}, allowed)) {
    if (value != std::floor(value) || value < 0 || value > 65536 || (v.size() >= 2 && value < 1))
      throw Error(ErrorKind::usage, fmt::format("--region {}: allowed is {}", text, allowed));
    v.push_back(static_cast<int>(value));
  }
  return Region{v[0], v[1], v[2], v[3]};
}

void check(const CompareOptions& o) {
  std::error_code none;
  for (std::size_t k = 0; k < o.images.size(); ++k)
    for (std::size_t other = 0; other < k; ++other)
      if (absolute_path(o.images[k]) == absolute_path(o.images[other]))
        throw Error(ErrorKind::usage, o.images[k] + ": named twice");
  if (o.page.empty()) return;
  const std::string extension = std::filesystem::path(o.page).extension().string();
  if (extension != ".html" && extension != ".htm")
    throw Error(ErrorKind::usage, o.page + ": the page is written as .html");
  require_writable(o.page);
}

/// Three digits, also where the last ones are 0.
std::string three_digits(double value) {
  std::string text = fmt::format("{:#.3g}", value);
  if (text.ends_with('.')) text.pop_back();
  return text;
}

/// With the unit.
std::string text_of(double value, const std::string& unit) {
  if (std::isnan(value)) return "-";
  if (unit == "%") return three_digits(100 * value) + " %";
  if (unit == "dB") return fmt::format("{:.2f} dB", value);
  return value == std::floor(value) && value < 1e9 ? fmt::format("{:.0f}", value) : three_digits(value);
}

/// One line a measure, one column a picture, smallest error first; pictures that do not fit 100 columns follow below.
std::string table(const Comparison& comparison) {
  using Line = std::vector<std::string>;
  const std::vector<std::size_t> order = by_error(comparison);
  std::vector<Line> lines(1, Line{""});
  for (const std::size_t k : order) lines[0].push_back(comparison.images[k].picture.name);
  const auto add = [&](const std::string& name, const auto& text) {
    lines.push_back({name});
    for (const std::size_t k : order) lines.back().push_back(text(comparison.images[k]));
  };
  const auto add_group = [&](const std::string& title, const ErrorMeasures ImageErrors::*group) {
    lines.push_back({title});
    add("  mean", [&](const auto& image) { return text_of((image.errors.*group).mean, ""); });
    for (const MeasureInfo& m : measure_table())
      add("  " + m.name, [&](const auto& image) { return text_of(m.value(image.errors.*group), m.unit); });
  };
  add_group("luminance", &ImageErrors::luminance);
  add_group("R, G, B", &ImageErrors::rgb);
  for (std::size_t k = 0; k < 3; ++k)
    add(fmt::format("  mean {} / reference", "RGB"[k]), [&](const auto& image) {
      const double r = image.errors.mean_rgb_reference[k];
      return r > 0 ? fmt::format("{:.3f}", image.errors.mean_rgb[k] / r) : std::string("-");
    });
  if (std::any_of(comparison.images.begin(), comparison.images.end(),
                  [](const auto& image) { return !std::isnan(image.flip_shown); })) {
    lines.push_back({"FLIP"});
    add("  HDR", [](const auto& image) { return text_of(image.flip, ""); });
    add("  as shown", [](const auto& image) { return text_of(image.flip_shown, ""); });
  }

  const Region& r = comparison.region;
  std::string out = fmt::format("reference {}: {}x{} pixels{}, mean luminance {:.4g}\n", comparison.reference.path,
                                comparison.width, comparison.height,
                                r.width == comparison.width && r.height == comparison.height
                                    ? ""
                                    : fmt::format(", region {},{},{},{}", r.x, r.y, r.width, r.height),
                                comparison.images.front().errors.luminance.mean_reference);
  constexpr std::size_t kNameWidth = 22, kPageWidth = 100;
  std::size_t width = 11;
  for (const std::string& name : lines[0]) width = std::max(width, name.size() + 2);
  const std::size_t at_once = std::max<std::size_t>(1, (kPageWidth - kNameWidth) / width);
  for (std::size_t first = 1; first <= order.size(); first += at_once) {
    out += "\n";
    for (const Line& line : lines) {
      std::string row = fmt::format("{:<{}}", line[0], kNameWidth);
      for (std::size_t k = first; k < std::min(first + at_once, line.size()); ++k)
        row += fmt::format("{:>{}}", line[k], width);
      row.erase(row.find_last_not_of(' ') + 1);
      out += row + "\n";
    }
  }
  return out;
}

std::string footer() {
  std::string text = R"(Examples:
  myrialux compare truth.exr a.exr b.exr
  myrialux compare truth.exr a.exr b.exr -o report.html
  myrialux compare truth.exr a.exr --json --flip | jq .images[0].flip
  myrialux compare truth.exr a.exr --region 100,50,64,64

Without -o and --json a table goes to stdout (with -o: if --flip is given). Measures, on luminance and on R, G, B:
)";
  const auto row = [&](const std::string& name, const std::string& meaning) {
    std::string line = fmt::format("  {:<20}", name);
    std::istringstream words(meaning);
    for (std::string word; words >> word; line += " " + word)
      if (line.size() + 1 + word.size() > 118) text += line + "\n", line = std::string(22, ' ');
    text += line + "\n";
  };
  for (const MeasureInfo& m : measure_table()) row(m.name, m.meaning);
  row("FLIP",
      "HDR-FLIP over exposures that the reference decides, and FLIP as shown, by the package flip-evaluator: what an "
      "eye notices, 0 to 1.");
  return text + R"(
The page and FLIP need Python with the packages of python/requirements.txt: tools/setup_python.sh installs them in
.venv. Python is $MYRIALUX_PYTHON, else that of .venv, else python3.
Exit codes: 0 done; 2 bad usage; 3 bad picture; 5 page not writable, Python or its packages missing.)";
}

}  // namespace
}  // namespace myrialux::app
