// The report: complete, self-contained and written whole.
#include "noiseloom/report/analyze.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <regex>
#include <set>

#include "noiseloom/image/image_io.h"
#include "noiseloom/image/image_reader.h"
#include "noiseloom/report/number_text.h"
#include "noiseloom/report/plot.h"
#include "noiseloom/report/report.h"
#include "support/mask_texture.h"

namespace noiseloom {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::UnorderedElementsAre;

SpectralQuality analyze(const TextureFile& file, const std::string& folder) {
  ThreadPool pool(2);
  OutputFiles output(posix_file_ops(), false);
  SpectralQuality quality = analyze_texture("folder/some & other.h5", file, folder, output, pool);
  output.commit();
  return quality;
}

TEST(Analyze, WritesPicturesTablesAndAPageThatNeedsNothingElse) {
  const TemporaryFolder folder;
  TextureFile file;
  file.config = small_config("hemisphere-cosine");
  file.texture = start_texture(*file.config);
  file.source = "run file";
  file.history = {{"sweep", {0, 1, 2}}, {"relative_error", {1, 0.5, 0.25}}, {"seconds", {0, 1.5, 2}}};
  analyze(file, folder.path());
  EXPECT_THAT(folder.names(),
              UnorderedElementsAre("report.html", "preview.png", "slice_0.png", "slice_1.png", "slice_2.png",
                                   "estimates.png", "error.png", "error_white_noise.png", "spectrum_xy.png",
                                   "spectrum_xy.csv", "autocorrelation.csv", "spectrum_xy.svg", "spectrum_xt.png",
                                   "spectrum_t.csv", "spectra.svg", "convergence.csv"));
  const std::string page = read_bytes(folder / "report.html");
  EXPECT_THAT(page, AllOf(HasSubstr("some &amp; other.h5"), HasSubstr("data:image/png;base64,"), HasSubstr("<svg"),
                          HasSubstr("box 3 over xy"), HasSubstr("Convergence")));
  EXPECT_THAT(page, AllOf(Not(HasSubstr("src='http")), Not(testing::ContainsRegex("href='[^d]")), Not(HasSubstr("<a ")),
                          Not(HasSubstr("<script"))));
  EXPECT_EQ(read_bytes(folder / "convergence.csv"), "sweep,relative_error,seconds\n0,1,0\n1,0.5,1.5\n2,0.25,2\n");
  EXPECT_THAT(read_bytes(folder / "spectrum_xy.csv"), testing::StartsWith("frequency_cycles_per_pixel,power,count\n"));
}

// Every combination of two and three axes that a filter may group; none may name a file of another section.
TEST(Analyze, WritesEachFileOnceWhateverTheFilterGroups) {
  for (const std::string axes : {"xt", "yt", "tz", "xz", "xyt", "xtz", "ytz", "xytz"}) {
    const TemporaryFolder folder;
    std::string rest;
    for (const char axis : std::string("xytz"))
      if (axes.find(axis) == std::string::npos) rest += axis;
    std::string groups = "{ axes = \"" + axes + "\", kernel = \"gauss\", sigma = 1.0 }";
    if (!rest.empty()) groups += ", { axes = \"" + rest + "\", kernel = \"gauss\", sigma = 1.0 }";
    TextureFile file;
    file.config = parse_config(
        "[texture]\nsize = { x = 7, y = 8, t = 5, z = 3 }\nsamples = \"uniform\"\n[filter]\n"
        "combine = \"product\"\ngroups = [ " +
            groups + " ]\n",
        "test.toml", "", {});
    file.texture = start_texture(*file.config);
    analyze(file, folder.path());
    EXPECT_THAT(folder.names(), testing::IsSupersetOf({"spectrum_xt.png", "spectrum_xz.png", "spectrum_xy.png"}))
        << axes;
    EXPECT_TRUE(std::filesystem::exists(folder / ("spectrum_" + axes + ".csv"))) << axes;
  }
}

// What stands between `before` and the next `after`, wherever `before` occurs.
std::vector<std::string> between(const std::string& text, const std::string& before, const std::string& after) {
  std::vector<std::string> found;
  for (std::size_t at = text.find(before); at != std::string::npos; at = text.find(before, at)) {
    at += before.size();
    found.push_back(text.substr(at, text.find(after, at) - at));
  }
  return found;
}

// A picture that is scaled by anything but a whole number shows seams that are not in the texture.
TEST(Analyze, ShowsPicturesPixelByPixel) {
  for (const std::string size : {"x = 11, y = 7, t = 3", "x = 268, y = 300, t = 2", "x = 1000, y = 3"}) {
    const TemporaryFolder folder;
    TextureFile file;
    file.config = small_config("vector2", size);
    file.texture = start_texture(*file.config);
    analyze(file, folder.path());
    const std::string page = read_bytes(folder / "report.html");
    std::vector<std::string> boxes;
    std::vector<std::string> images;
    for (const std::string& figure : between(page, "<figure style='width:", " src=")) {
      if (figure.find("<img") == std::string::npos) continue;
      boxes.push_back(figure.substr(0, figure.find("px'")));
      images.push_back(between(figure, " width='", "'").front());
    }
    EXPECT_EQ(boxes, images);
    EXPECT_GE(images.size(), 4U);
    for (const std::string& width : images) EXPECT_LE(std::stoi(width), page_width);
    // Nothing that takes room inside the image's box.
    EXPECT_THAT(between(page, "figure img {", "}"),
                testing::Each(AllOf(Not(HasSubstr("border")), Not(HasSubstr("padding")), Not(HasSubstr(" width")))));
  }
}

TEST(Analyze, SaysWhatEachNumberIsAndWhatMadeThePage) {
  const TemporaryFolder folder;
  TextureFile file;
  file.config = small_config("uniform");
  file.texture = start_texture(*file.config);
  file.history = {{"iterations", {0, 1, 2}}, {"relative_error", {1, 0.5, 0.25}}, {"seconds", {0, 1.5, 2}}};
  ThreadPool pool(1);
  OutputFiles output(posix_file_ops(), false);
  analyze_texture("a.h5", file, folder.path(), output, pool, {"1.2.3", "2001-02-03", "noiseloom analyze 'a b.h5'"});
  output.commit();
  const std::string page = read_bytes(folder / "report.html");
  EXPECT_THAT(page, AllOf(HasSubstr("R: relative error of the whole texture after its own filter"),
                          HasSubstr("R of single slices"), HasSubstr("This is one slice, one question"),
                          HasSubstr("after each of these filters"), HasSubstr("while it was made"),
                          HasSubstr("noiseloom 1.2.3, 2001-02-03"), HasSubstr("noiseloom analyze &#39;a b.h5&#39;"),
                          HasSubstr("@media print"), Not(HasSubstr("<details"))));
  // Both axes of the spectra have their names.
  EXPECT_THAT(page,
              AllOf(HasSubstr("frequency along y (cycles a pixel)"), HasSubstr("frequency along t (cycles a slice)")));
}

TEST(NumberText, HasNoExponentAndNoZerosAtTheEnd) {
  EXPECT_EQ(number_text(0, 3), "0");
  EXPECT_EQ(number_text(1, 3), "1");
  EXPECT_EQ(number_text(5e-4, 4), "0.0005");
  EXPECT_EQ(number_text(3.6912e-5, 3), "0.0000369");
  EXPECT_EQ(number_text(0.0218, 3), "0.0218");
  EXPECT_EQ(number_text(123456.7, 3), "123457");
  EXPECT_EQ(number_text(-0.25, 4), "-0.25");
  EXPECT_EQ(number_text(99.999, 3), "100");
  EXPECT_EQ(number_text(1e-20, 3), "0");
  EXPECT_EQ(number_text(std::nan(""), 3), "none");
}

TEST(Analyze, NeedsNoConfigForPicturesAndSpectra) {
  const TemporaryFolder folder;
  TextureFile file;
  file.texture = start_texture(small_config("vector2", "x = 11, y = 7"));
  file.source = "one image, 8 bit";
  analyze(file, folder.path());
  EXPECT_THAT(folder.names(), UnorderedElementsAre("report.html", "preview.png", "spectrum_xy.png", "spectrum_xy.csv",
                                                   "autocorrelation.csv", "spectrum_xy.svg", "spectra.svg"));
}

TEST(Analyze, ShowsThePointsOfAMaskAndTheAxesThatItsFilterGroups) {
  const TemporaryFolder folder;
  const VacSpec spec = testing_support::vac_spec({23, 21, 5, 7}, {{0, 1}, {2, 3}});
  write_mask_file(folder / "mask.h5", spec.extents, mask_places(spec));
  const SpectralQuality quality = analyze(load_texture(folder / "mask.h5", std::nullopt), folder / "report");
  for (const char* const name :
       {"points_0.02.png", "points_0.5.png", "spectrum_tz.png", "spectrum_tz.csv", "spectrum_xz.png", "spectra.svg"})
    EXPECT_TRUE(std::filesystem::exists(folder / "report/" + name)) << name;
  const std::string page = read_bytes(folder / "report/report.html");
  EXPECT_THAT(
      page, AllOf(HasSubstr("Point sets"), HasSubstr("2 %: 338 points in all; first slice."),
                  HasSubstr("50 %: 8452 points"), HasSubstr("averaged over rings and 16 slices"),
                  HasSubstr("Spectrum over t and z"), HasSubstr("<td>tz</td>"), HasSubstr("no frequency is that low")));
  ASSERT_EQ(quality.groups.size(), 4U);
  EXPECT_THAT(page, HasSubstr("<td>" + number_text(quality.groups[0].low_frequency_power, 3) + "</td>"));
  // Every pixel 9 times as large: 9 times 23 fit 222.
  ImageReader reader(folder / "report/points_0.02.png");
  std::vector<std::byte> bytes(reader.shape(0).num_bytes());
  reader.read_rows(0, 0, reader.shape(0).height, bytes);
  const auto order = mask_places(spec);
  ASSERT_EQ(reader.shape(0).height, 21 * 9);
  ASSERT_EQ(reader.shape(0).width, 23 * 9);
  for (std::size_t y = 0; y < 21; ++y)
    for (std::size_t x = 0; x < 23; ++x)
      ASSERT_EQ(std::to_integer<int>(bytes[3 * ((9 * y + 4) * 23 * 9 + 9 * x + 4)]), order[x + 23 * y] < 338 ? 0 : 255);
}

TEST(Analyze, RefusesAMaskThatIsNotFinished) {
  const TemporaryFolder folder;
  std::vector<std::uint64_t> places(35);
  for (std::size_t p = 0; p < 35; ++p) places[p] = p;
  places[3] = off_without_place;
  write_mask_file(folder / "mask.h5", Extents({7, 5}), places);
  EXPECT_THAT(user_error_of([&] { load_texture(folder / "mask.h5", std::nullopt); }),
              HasSubstr("mask.h5: not finished: 34 of 35 pixels"));
}

TEST(Analyze, LeavesAnExistingReportAlone) {
  const TemporaryFolder folder;
  TextureFile file;
  file.texture = start_texture(small_config("uniform", "x = 11, y = 7"));
  write_bytes(folder / "report.html", "mine");
  EXPECT_THAT(user_error_of([&] { analyze(file, folder.path()); }), HasSubstr("exists"));
  EXPECT_THAT(folder.names(), ElementsAre("report.html"));
  EXPECT_EQ(read_bytes(folder / "report.html"), "mine");
}

TEST(Base64, MatchesTheStandardsExamples) {  // RFC 4648, section 10
  const std::vector<std::pair<std::string, std::string>> examples = {
      {"", ""}, {"f", "Zg=="}, {"fo", "Zm8="}, {"foo", "Zm9v"}, {"foob", "Zm9vYg=="}, {"foobar", "Zm9vYmFy"}};
  for (const auto& [plain, encoded] : examples)
    EXPECT_EQ(base64(std::as_bytes(std::span(plain.data(), plain.size()))), encoded);
  const unsigned char high[] = {0xff, 0xfe, 0xfd};
  EXPECT_EQ(base64(std::as_bytes(std::span(high))), "//79");
}

TEST(Plot, PlacesTicksAtRoundNumbersInside) {
  EXPECT_THAT(linear_ticks(0, 1, 5),
              ElementsAre(0, 0.2, testing::DoubleEq(0.4), testing::DoubleNear(0.6, 1e-12), testing::DoubleEq(0.8), 1));
  EXPECT_THAT(linear_ticks(3, 47, 5), ElementsAre(10, 20, 30, 40));
  for (const double scale : {1e-6, 1.0, 3e7})
    for (const double tick : linear_ticks(-0.7 * scale, 1.3 * scale, 6)) {
      EXPECT_GE(tick, -0.7 * scale * (1 + 1e-9));
      EXPECT_LE(tick, 1.3 * scale * (1 + 1e-9));
    }
}

TEST(Plot, SurvivesLinesWithNothingToShow) {
  Plot plot{"title", "x", "y", true, {PlotLine{"all <= 0", {0, 1}, {0, -1}}, PlotLine{"one", {2}, {3}}, PlotLine{}}};
  EXPECT_THAT(plot_svg(plot), AllOf(HasSubstr("all &lt;= 0"), Not(HasSubstr("nan")), Not(HasSubstr("inf"))));
  plot.lines.clear();
  plot.log_y = false;
  EXPECT_THAT(plot_svg(plot), Not(HasSubstr("nan")));
}

// Words of an axis and of the legend, with the room that they take at 6.6 units a letter.
TEST(Plot, WordsDoNotLieOnEachOther) {
  Plot plot{"title", "seconds", "power, white noise = 1", true, {}, true};
  for (const char* const name :
       {"this texture", "filter lets through", "another one of them", "white noise", "xyz", "the last of all"})
    plot.lines.push_back({name, {1e-7, 1e6}, {3e-8, 20}});
  const std::string svg = plot_svg(plot);
  struct Box {
    double x0, x1, y;
  };
  std::vector<Box> boxes;
  const std::regex text(
      "<text class='nl-(tick|label)'( text-anchor='(middle|end)')? x='([-0-9.]+)' y='([-0-9.]+)'>([^<]*)<");
  for (std::sregex_iterator at(svg.begin(), svg.end(), text), end; at != end; ++at) {
    const double width = 6.6 * static_cast<double>((*at)[6].length());
    const double x = std::stod((*at)[4]) - ((*at)[3] == "middle" ? width / 2 : (*at)[3] == "end" ? width : 0);
    boxes.push_back({x, x + width, std::stod((*at)[5])});
    EXPECT_GE(boxes.back().x0, 0) << (*at)[6];
    EXPECT_LE(boxes.back().x1, plot.width) << (*at)[6];
  }
  ASSERT_GT(boxes.size(), 15U);
  for (std::size_t a = 0; a < boxes.size(); ++a)
    for (std::size_t b = 0; b < a; ++b)
      EXPECT_FALSE(boxes[a].x0 < boxes[b].x1 && boxes[b].x0 < boxes[a].x1 && std::abs(boxes[a].y - boxes[b].y) < 12)
          << a << " and " << b << "\n"
          << svg;
  EXPECT_THAT(svg, Not(testing::ContainsRegex(">[0-9.]+e-?[0-9]+<")));
}

TEST(Plot, TheLegendHasItsLinesInTheirOrderAndEachALookOfItsOwn) {
  using Style = PlotLine::Style;
  const std::vector<std::pair<const char*, Style>> lines = {
      {"white", Style::dashed},      {"blue", Style::main},         {"golden", Style::second},
      {"sobol-owen", Style::third},  {"stbn", Style::fourth},       {"for a box", Style::fifth},
      {"for a gauss", Style::sixth}, {"for three", Style::seventh}, {"the last", Style::eighth}};
  Plot plot{"title", "frame", "error", true, {}, true};
  for (const auto& [name, style] : lines) plot.lines.push_back({name, {1, 2}, {3, 4}, style});
  const std::string svg = plot_svg(plot);
  std::pair<double, double> before = {0, 0};  // y, x
  std::set<std::string> looks;
  for (const auto& [name, style] : lines) {
    std::smatch found;
    ASSERT_TRUE(std::regex_search(
        svg, found, std::regex(std::string("x='([0-9.]+)' y='([0-9.]+)'>") + name + "</text><line class='([a-z-]+)'")));
    const std::pair place = {std::stod(found[2]), std::stod(found[1])};
    EXPECT_LT(before, place) << name;
    before = place;
    std::smatch look;
    ASSERT_TRUE(std::regex_search(svg, look, std::regex("\\." + found[3].str() + "\\{([^}]*)")));
    EXPECT_TRUE(looks.insert(look[1]).second) << name;
  }
}

TEST(Plot, ABandIsOneAreaAlongItsLine) {
  PlotLine line{"errors", {1, 10}, {1, 2}};
  line.low = {0.5, 1};
  line.high = {2, 4};
  line.has_band = true;
  const std::string svg = plot_svg({"title", "x", "y", true, {line}, true});
  EXPECT_THAT(svg, testing::ContainsRegex("<polygon class='nl-main nl-band' points='([0-9.]+,[0-9.]+ ){4}'/>"));
  EXPECT_THAT(svg.substr(svg.find("<polyline")), Not(HasSubstr("<line class='nl-main' x1='58")));
}

TEST(Plot, LogarithmicXPlacesEqualRatiosAtEqualDistances) {
  PlotLine line{"runs", {1, 10, 100}, {1, 1, 1}};
  Plot plot{"title", "x", "y", true, {line}, true};
  const std::string svg = plot_svg(plot);
  // Two points of a ratio of 100 at the ends (58 and 606 of 620), the third half-way.
  EXPECT_THAT(svg, testing::ContainsRegex("points='58\\.0,[0-9.]+ 332\\.0,[0-9.]+ 606\\.0,"));
}

TEST(Plot, MarkersCarryTheirNamesAndPointsAloneHaveNoLine) {
  PlotLine line{"runs", {1, 10}, {3, 1}, PlotLine::Style::points, {"first & best", "second"}, {"note", "other"}};
  Plot plot{"title", "x", "y", true, {line}, true, {{"default", 10, 1}}};
  const std::string svg = plot_svg(plot);
  EXPECT_THAT(svg, AllOf(HasSubstr("<title>first &amp; best</title>"), HasSubstr(">other</text>"),
                         HasSubstr(">default</text>"), HasSubstr("nl-ring"), Not(HasSubstr("<polyline"))));
}

TEST(Report, TablesAreEscapedAndTheirCommandsStandUnderThem) {
  Report report;
  report.title = "t";
  report.findings = {"a < b"};
  report.sections = {{"s", "", {}, {ReportTable{{"point", "R"}, {{{"x & y", "0.5"}, "run --set 'a=1'", true}}}}}};
  EXPECT_THAT(report_html(report), AllOf(HasSubstr("a &lt; b"), HasSubstr("<td>x &amp; y</td>"),
                                         HasSubstr("<code>run --set &#39;a=1&#39;</code>"), HasSubstr("colspan='2'")));
}

}  // namespace
}  // namespace noiseloom
