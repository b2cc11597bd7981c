#include "image/export_points.h"

#include <fmt/format.h>

#include <iterator>

#include "noiseloom/files/npy.h"

namespace noiseloom {
namespace {

constexpr std::size_t piece_bytes = std::size_t{1} << 20;

// The points of a range of slices, in the order of the whole sequence.
class PointRows {
 public:
  PointRows(const ExportPlan& plan, const Extents& extents, const PixelOrder& order)
      : extents_(extents), begin_(plan.begin), end_(plan.end), positions_(order.first_pixels(*plan.num_points)) {}

  int num_columns() const { return extents_.num_axes() + 1; }
  std::int64_t count() const {
    std::int64_t count = 0;
    for_each([&](const std::vector<std::int64_t>&) { ++count; });
    return count;
  }
  // visit(row): coordinates, then rank.
  template <class Visit>
  void for_each(Visit visit) const {
    const auto cells = static_cast<std::uint64_t>(extents_.cells_per_slice());
    const auto width = static_cast<std::uint64_t>(extents_.width());
    std::vector<std::int64_t> row(static_cast<std::size_t>(num_columns()));
    for (std::size_t rank = 0; rank < positions_.size(); ++rank) {
      const auto slice = static_cast<SliceIndex>(positions_[rank] / cells);
      if (slice < begin_ || slice >= end_) continue;
      const std::uint64_t cell = positions_[rank] % cells;
      row[0] = static_cast<std::int64_t>(cell % width);
      row[1] = static_cast<std::int64_t>(cell / width);
      const Extents::SliceCoord coord = extents_.slice_coord(slice);
      for (std::size_t a = 0; a < static_cast<std::size_t>(extents_.num_slice_axes()); ++a) row[2 + a] = coord[a];
      row.back() = static_cast<std::int64_t>(rank);
      visit(row);
    }
  }

 private:
  const Extents& extents_;
  SliceIndex begin_;
  SliceIndex end_;
  std::vector<std::uint64_t> positions_;
};

void write_csv(OutputFiles& files, const std::string& target, const Extents& extents, const PointRows& rows) {
  std::string text;
  for (int axis = 0; axis < extents.num_axes(); ++axis) text += extents.name(axis) + ",";
  text += "rank\n";
  files.write_pieces(target, [&](const OutputFiles::Append& append) {
    const auto flush = [&] {
      append(std::as_bytes(std::span(text.data(), text.size())));
      text.clear();
    };
    rows.for_each([&](const std::vector<std::int64_t>& row) {
      for (const std::int64_t number : row) fmt::format_to(std::back_inserter(text), "{},", number);
      text.back() = '\n';
      if (text.size() >= piece_bytes) flush();
    });
    flush();
  });
}

void write_npy_rows(OutputFiles& files, const std::string& target, const PointRows& rows, std::int64_t count) {
  const std::vector<std::int64_t> shape = {count, rows.num_columns()};
  files.write_pieces(target, [&](const OutputFiles::Append& append) {
    const std::string header = npy_int64_header(shape);
    append(std::as_bytes(std::span(header.data(), header.size())));
    std::vector<std::int64_t> numbers;
    const auto flush = [&] {
      append(std::as_bytes(std::span(numbers)));
      numbers.clear();
    };
    rows.for_each([&](const std::vector<std::int64_t>& row) {
      numbers.insert(numbers.end(), row.begin(), row.end());
      if (numbers.size() * sizeof(std::int64_t) >= piece_bytes) flush();
    });
    flush();
  });
}

}  // namespace

std::string write_points(OutputFiles& files, const ExportPlan& plan, const Extents& extents, const PixelOrder& order) {
  const PointRows rows(plan, extents, order);
  const std::int64_t count = rows.count();
  write_csv(files, plan.points_csv, extents, rows);
  if (!plan.points_npy.empty()) write_npy_rows(files, plan.points_npy, rows, count);
  std::string text = fmt::format("{} points: the earliest of {} pixels", *plan.num_points, extents.num_cells());
  if (plan.end - plan.begin != extents.num_slices())
    text += fmt::format("; {} of them in slices {} to {}", count, plan.begin, plan.end - 1);
  return text;
}

}  // namespace noiseloom
