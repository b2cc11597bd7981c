// The report: complete, self-contained and written whole.
#include "noiseloom/report/analyze.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "noiseloom/image/image_io.h"
#include "noiseloom/image/image_reader.h"
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
              UnorderedElementsAre("report.html", "preview.png", "slices.png", "estimates.png", "error.png",
                                   "error_white_noise.png", "spectrum_xy.png", "spectrum_xy.csv", "spectrum_xy.svg",
                                   "spectrum_xt.png", "spectrum_t.csv", "spectra.svg", "convergence.csv"));
  const std::string page = read_bytes(folder / "report.html");
  EXPECT_THAT(page, AllOf(HasSubstr("some &amp; other.h5"), HasSubstr("data:image/png;base64,"), HasSubstr("<svg"),
                          HasSubstr("box 3 over xy"), HasSubstr("Convergence")));
  EXPECT_THAT(page, AllOf(Not(HasSubstr("src='http")), Not(HasSubstr("href=")), Not(HasSubstr("<script"))));
  EXPECT_EQ(read_bytes(folder / "convergence.csv"), "sweep,relative_error,seconds\n0,1,0\n1,0.5,1.5\n2,0.25,2\n");
  EXPECT_THAT(read_bytes(folder / "spectrum_xy.csv"), testing::StartsWith("frequency_cycles_per_pixel,power,count\n"));
}

TEST(Analyze, NeedsNoConfigForPicturesAndSpectra) {
  const TemporaryFolder folder;
  TextureFile file;
  file.texture = start_texture(small_config("vector2", "x = 11, y = 7"));
  file.source = "one image, 8 bit";
  analyze(file, folder.path());
  EXPECT_THAT(folder.names(), UnorderedElementsAre("report.html", "preview.png", "spectrum_xy.png", "spectrum_xy.csv",
                                                   "spectrum_xy.svg", "spectra.svg"));
}

TEST(Analyze, ShowsThePointsOfAMaskAndTheAxesThatItsFilterGroups) {
  const TemporaryFolder folder;
  const VacSpec spec = testing_support::vac_spec({23, 21, 5, 7}, {{0, 1}, {2, 3}});
  write_mask_file(folder / "mask.h5", spec.extents, mask_ranks(spec));
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
  EXPECT_THAT(page, HasSubstr(fmt::format("<td>{:.3g}</td>", quality.groups[0].low_frequency_power)));
  // Every pixel 9 times as large: 9 times 23 fit 222.
  ImageReader reader(folder / "report/points_0.02.png");
  std::vector<std::byte> bytes(reader.shape(0).num_bytes());
  reader.read_rows(0, 0, reader.shape(0).height, bytes);
  const auto order = mask_ranks(spec);
  ASSERT_EQ(reader.shape(0).height, 21 * 9);
  ASSERT_EQ(reader.shape(0).width, 23 * 9);
  for (std::size_t y = 0; y < 21; ++y)
    for (std::size_t x = 0; x < 23; ++x)
      ASSERT_EQ(std::to_integer<int>(bytes[3 * ((9 * y + 4) * 23 * 9 + 9 * x + 4)]), order[x + 23 * y] < 338 ? 0 : 255);
}

TEST(Analyze, RefusesAMaskThatIsNotFinished) {
  const TemporaryFolder folder;
  std::vector<std::uint64_t> ranks(35);
  for (std::size_t p = 0; p < 35; ++p) ranks[p] = p;
  ranks[3] = ~std::uint32_t{0};
  write_mask_file(folder / "mask.h5", Extents({7, 5}), ranks);
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
