// Masks to point sets: the images, the coordinates and the mask they come from say the same.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <numeric>

#include "noiseloom/files/npy.h"
#include "noiseloom/files/pixel_order.h"
#include "noiseloom/image/export.h"
#include "noiseloom/image/image_reader.h"
#include "support/mask_texture.h"

namespace noiseloom {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::UnorderedElementsAre;

// 11 x 7 x 3 x 2; places a fixed permutation: 462 = 2 3 7 11, and 125 is coprime to it.
const Extents extents({11, 7, 3, 2});
std::uint64_t test_place(std::size_t position) { return (position * 125 + 17) % 462; }

std::vector<std::uint64_t> test_places() {
  std::vector<std::uint64_t> places(462);
  for (std::size_t p = 0; p < places.size(); ++p) places[p] = test_place(p);
  return places;
}

ExportOptions points_options(const std::string& output, const std::string& threshold) {
  ExportOptions options;
  options.output = output;
  options.threshold = threshold;
  return options;
}

// The table that belongs to the first `count` pixels; slices in [begin, end) alone.
std::string expected_csv(std::size_t count, std::size_t begin = 0, std::size_t end = 6) {
  std::vector<std::size_t> position_of_place(462);
  for (std::size_t p = 0; p < 462; ++p) position_of_place[test_place(p)] = p;
  std::string text = "x,y,t,z,place\n";
  for (std::size_t place = 0; place < count; ++place) {
    const std::size_t p = position_of_place[place];
    const std::size_t slice = p / 77;
    if (slice >= begin && slice < end)
      text += fmt::format("{},{},{},{},{}\n", p % 11, p / 11 % 7, slice % 3, slice / 3, place);
  }
  return text;
}

class ExportedPoints : public testing::TestWithParam<ElementType> {};
INSTANTIATE_TEST_SUITE_P(Types, ExportedPoints, testing::Values(ElementType::uint32, ElementType::uint64));

TEST_P(ExportedPoints, AreTheEarliestPixelsInTheirOrder) {
  const TemporaryFolder folder;
  write_mask_file(folder / "mask.h5", extents, test_places(), GetParam());
  for (const auto& [threshold, count] : {std::pair{"0.1", 46U}, {"0.5", 231U}, {"1", 462U}, {"0.0022", 1U}}) {
    const std::string out = folder / ("out" + std::string(threshold)) + "/";
    const ExportResult result = export_run_file(folder / "mask.h5", points_options(out, threshold), posix_file_ops());
    EXPECT_EQ(result.points, fmt::format("{} points: the earliest of 462 pixels", count));
    EXPECT_EQ(result.files.size(), 6U);
    EXPECT_THAT(result.tables, ElementsAre(out + "points_below" + threshold + ".csv"));
    EXPECT_EQ(read_bytes(out + "points_below" + threshold + ".csv"), expected_csv(count));
    for (const SliceIndex s : first_indices<SliceIndex>(6)) {
      ImageReader reader(fmt::format("{}mask_below{}_{}.png", out, threshold, s.value()));
      EXPECT_EQ(reader.shape(0).channels, 1);
      std::vector<std::byte> bytes(reader.shape(0).num_bytes());
      ASSERT_EQ(bytes.size(), 77U);
      reader.read_rows(0, 0, 7, bytes);
      for (std::size_t cell = 0; cell < 77; ++cell) {
        const bool on = test_place(cell + 77 * static_cast<std::size_t>(s)) < count;
        EXPECT_EQ(std::to_integer<int>(bytes[cell]), on ? 255 : 0);
      }
    }
  }
}

TEST_P(ExportedPoints, AreArraysToo) {
  const TemporaryFolder folder;
  write_mask_file(folder / "mask.h5", extents, test_places(), GetParam());
  ExportOptions options = points_options(folder / "out/", "0.25");
  options.format = "npy";
  export_run_file(folder / "mask.h5", options, posix_file_ops());
  const NpyArray mask = read_npy(folder / "out/mask_below0.25.npy");
  EXPECT_THAT(mask.shape, ElementsAre(2, 3, 7, 11, 1));
  for (std::size_t p = 0; p < 462; ++p) EXPECT_EQ(mask.values[p], test_place(p) < 115 ? 1 : 0);
  const NpyArray points = read_npy(folder / "out/points_below0.25.npy");
  EXPECT_THAT(points.shape, ElementsAre(115, 5));
  std::string text = "x,y,t,z,place\n";
  for (std::size_t i = 0; i < points.values.size(); ++i)
    text += fmt::format("{}{}", points.values[i], i % 5 == 4 ? "\n" : ",");
  EXPECT_EQ(text, expected_csv(115));
  EXPECT_EQ(read_bytes(folder / "out/points_below0.25.csv"), text);
}

TEST(ExportPoints, OfSomeSlicesKeepTheirPlacesInTheWhole) {
  const TemporaryFolder folder;
  write_mask_file(folder / "mask.h5", extents, test_places());
  ExportOptions options = points_options(folder / "out", "0.5");
  options.slices = "2:4";
  const ExportResult result = export_run_file(folder / "mask.h5", options, posix_file_ops());
  const std::string csv = expected_csv(231, 2, 4);
  EXPECT_EQ(read_bytes(folder / "out/points_below0.5.csv"), csv);
  EXPECT_EQ(result.points, fmt::format("231 points: the earliest of 462 pixels; {} of them in slices 2 to 3",
                                       std::count(csv.begin(), csv.end(), '\n') - 1));
}

TEST(ExportPoints, FollowTheFormatsLayoutsAndNames) {
  const TemporaryFolder folder;
  write_mask_file(folder / "mask.h5", extents, test_places());
  const auto files = [&](const std::string& output, const std::string& format, const std::string& layout,
                         const std::string& naming) {
    ExportOptions options = points_options(folder / output, "0.1");
    options.format = format;
    options.layout = layout;
    options.naming = naming;
    std::vector<std::string> names;
    const ExportResult result = export_run_file(folder / "mask.h5", options, posix_file_ops());
    for (const auto* list : {&result.files, &result.tables})
      for (const std::string& file : *list) names.push_back(file.substr(folder.path().size() + 1));
    return names;
  };
  EXPECT_THAT(files("a/", "exr", "strip", "nvidia"),
              UnorderedElementsAre("a/stbn_scalar_2Dx2D_11x7x3x2_below0.1.exr", "a/points_below0.1.csv"));
  EXPECT_THAT(files("b.tif", "", "strip", ""), UnorderedElementsAre("b.tif", "b_points.csv"));
  EXPECT_THAT(files("c.npy", "", "", ""), UnorderedElementsAre("c.npy", "c_points.npy", "c_points.csv"));
  EXPECT_THAT(files("d/p{}.hdr", "", "", ""),
              AllOf(testing::SizeIs(7), testing::Contains("d/p5.hdr"), testing::Contains("d/points_below0.1.csv")));
  EXPECT_THAT(files("e/", "raw", "", ""), AllOf(testing::SizeIs(3), testing::Contains("e/points_below0.1.csv")));
  for (const std::string name :
       {"a/stbn_scalar_2Dx2D_11x7x3x2_below0.1.exr", "b.tif", "c.npy", "d", "e/mask_below0.1.raw"}) {
    const TextureFile loaded = load_texture(folder / name, mask_config(extents));
    ASSERT_EQ(loaded.texture.values.size(), 462U) << name;
    for (std::size_t p = 0; p < 462; ++p)
      ASSERT_EQ(loaded.texture.values[p] > 0.5F, test_place(p) < 46) << name << " " << p;
  }
}

TEST(ExportPoints, RefusesFilesWithoutASequenceOrWithHalfOfOne) {
  const TemporaryFolder folder;
  const auto error = [&](const std::string& file) {
    return user_error_of(
        [&] { export_run_file(folder / file, points_options(folder / "out/", "0.1"), posix_file_ops()); });
  };
  const RunConfig config = small_config("uniform");
  write_run_file(folder / "plain.h5", config, start_texture(config));
  EXPECT_THAT(error("plain.h5"), AllOf(HasSubstr("plain.h5: holds no /order"), HasSubstr("\"void-and-cluster\"")));
  for (const ElementType type : {ElementType::uint32, ElementType::uint64}) {
    std::vector<std::uint64_t> places = test_places();
    places[5] = off_without_place;
    places[461] = on_without_place;
    write_mask_file(folder / "half.h5", extents, places, type);
    EXPECT_THAT(error("half.h5"), AllOf(HasSubstr("not finished: 460 of 462"), HasSubstr("--resume")));
  }
  std::vector<std::uint64_t> places = test_places();
  *std::find(places.begin(), places.end(), 13U) = 14;
  write_mask_file(folder / "twice.h5", extents, places);
  EXPECT_THAT(error("twice.h5"), HasSubstr("two pixels have place 14"));
  // The pixel that has place 46 a second time is no point: the point of place 13 is what is missing.
  *std::find(places.begin(), places.end(), 14U) = 46;
  write_mask_file(folder / "none.h5", extents, places);
  EXPECT_THAT(error("none.h5"), HasSubstr("none has place "));
  EXPECT_FALSE(std::filesystem::exists(folder / "out"));
}

TEST(ExportPoints, OfSeveralDensitiesFitIntoOneFolder) {
  const TemporaryFolder folder;
  write_mask_file(folder / "mask.h5", extents, test_places());
  for (const char* const format : {"png", "npy", "raw"})
    for (const char* const threshold : {"0.02", "0.1", "0.25", "0.5", "1"}) {
      ExportOptions options = points_options(folder / format + "/", threshold);
      options.format = format;
      EXPECT_EQ(user_error_of([&] { export_run_file(folder / "mask.h5", options, posix_file_ops()); }), "");
    }
}

TEST(ExportPoints, AreWrittenAsATableAlone) {
  const TemporaryFolder folder;
  write_mask_file(folder / "mask.h5", extents, test_places());
  const ExportResult result =
      export_run_file(folder / "mask.h5", points_options(folder / "a.CSV", "0.1"), posix_file_ops());
  EXPECT_THAT(result.files, testing::IsEmpty());
  EXPECT_THAT(result.tables, ElementsAre(folder / "a.CSV"));
  EXPECT_EQ(read_bytes(folder / "a.CSV"), expected_csv(46));
  EXPECT_EQ(result.points, "46 points: the earliest of 462 pixels");
  EXPECT_THAT(user_error_of(
                  [&] { export_run_file(folder / "mask.h5", points_options(folder / "b.csv", ""), posix_file_ops()); }),
              AllOf(HasSubstr("give its density with --threshold"), HasSubstr("accepted for the values")));
}

TEST(ExportPoints, TellsAllFaultsAtOnceAndTouchesNothing) {
  const TemporaryFolder folder;
  write_mask_file(folder / "mask.h5", extents, test_places());
  ExportOptions options = points_options(folder / "out/", "0.001");
  options.density = "alpha";
  options.range = "0:1";
  options.slices = "4:9";
  EXPECT_THAT(user_error_of([&] { export_run_file(folder / "mask.h5", options, posix_file_ops()); }),
              AllOf(HasSubstr("no point of 462 pixels; the least that is one: 0.00216"),
                    HasSubstr("--pdf: a point set"), HasSubstr("--range: a point set"), HasSubstr("0 <= A < B <= 6")));
  std::filesystem::create_directory(folder / "out");
  write_bytes(folder / "out/points_below0.1.csv", "mine");
  EXPECT_THAT(user_error_of([&] {
                export_run_file(folder / "mask.h5", points_options(folder / "out/", "0.1"), posix_file_ops());
              }),
              HasSubstr("points_below0.1.csv: exists; --overwrite replaces it"));
  EXPECT_EQ(read_bytes(folder / "out/points_below0.1.csv"), "mine");
  EXPECT_THAT(folder.names(), UnorderedElementsAre("mask.h5", "out"));
  options = points_options(folder / "out/", "0.1");
  options.overwrite = true;
  export_run_file(folder / "mask.h5", options, posix_file_ops());
  EXPECT_EQ(read_bytes(folder / "out/points_below0.1.csv"), expected_csv(46));
}

}  // namespace
}  // namespace noiseloom
