// The points of a mask as tables: a row for each point that lies in the slices exported, in the order of the sequence.
// Columns are the coordinates (x, y, slice axes) and the place in the whole sequence. As text (.csv, with the names of
// the columns) or as int64 [points][axes + 1] (.npy).
#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <iterator>
#include <limits>

#include "image/containers/container_writers.h"
#include "noiseloom/core/error.h"
#include "noiseloom/files/npy.h"
#include "noiseloom/files/pixel_order.h"

namespace noiseloom {
namespace {

constexpr std::size_t piece_bytes = std::size_t{1} << 20;
constexpr std::uint64_t not_seen = std::numeric_limits<std::uint64_t>::max();

class PointsWriter : public ContainerWriter {
 public:
  explicit PointsWriter(OutputFiles& files) : files_(files) {}

  void begin(const std::string& target, const ContainerJob& job) override {
    job_ = &job;
    stream_ = files_.open(target);
    num_points_ = OrderPlace(*job.num_points);
    positions_ =
        IndexedVector<OrderPlace, std::uint64_t>(std::vector(static_cast<std::size_t>(*job.num_points), not_seen));
  }

  void slice(SliceIndex slice, std::span<const std::byte> bytes) override {
    const auto cells = static_cast<std::uint64_t>(job_->extents.cells_per_slice());
    for (std::uint64_t cell = 0; cell < cells; ++cell) {
      OrderPlace place;
      std::memcpy(&place, bytes.data() + cell * sizeof place, sizeof place);
      if (place >= num_points_) continue;
      if (positions_[place] != not_seen) fail(fmt::format("two pixels have place {}", place.value()));
      positions_[place] = cell + cells * static_cast<std::uint64_t>(slice);
    }
  }

  void end() override {
    const auto missing = std::find(positions_.begin(), positions_.end(), not_seen);
    if (job_->holds_all_slices() && missing != positions_.end())
      fail(fmt::format("none has place {}", missing - positions_.begin()));
    write_rows();
    stream_->close();
    positions_ = {};
  }

 protected:
  int num_columns() const { return job_->extents.num_axes() + 1; }
  const ContainerJob& job() const { return *job_; }
  std::int64_t num_rows() const {
    return std::count_if(positions_.begin(), positions_.end(), [](std::uint64_t at) { return at != not_seen; });
  }
  void append(std::span<const std::byte> bytes) { stream_->append(bytes); }
  void append(const std::string& text) { stream_->append(text); }

  // visit(row): coordinates, then place.
  template <class Visit>
  void for_each_row(Visit visit) const {
    const Extents& extents = job_->extents;
    const auto cells = static_cast<std::uint64_t>(extents.cells_per_slice());
    const auto width = static_cast<std::uint64_t>(extents.width());
    std::vector<std::int64_t> row(static_cast<std::size_t>(num_columns()));
    for (const OrderPlace place : positions_.keys()) {
      if (positions_[place] == not_seen) continue;
      const std::uint64_t cell = positions_[place] % cells;
      row[0] = static_cast<std::int64_t>(cell % width);
      row[1] = static_cast<std::int64_t>(cell / width);
      const Extents::SliceCoord coord = extents.slice_coord(SliceIndex(positions_[place] / cells));
      for (std::size_t a = 0; a < static_cast<std::size_t>(extents.num_slice_axes()); ++a) row[2 + a] = coord[a];
      row.back() = static_cast<std::int64_t>(place.value());
      visit(row);
    }
  }

 private:
  virtual void write_rows() = 0;
  [[noreturn]] void fail(const std::string& why) const {
    throw UserError(job_->source, "/order is no sequence of the pixels: " + why);
  }

  OutputFiles& files_;
  const ContainerJob* job_ = nullptr;
  std::unique_ptr<OutputStream> stream_;
  OrderPlace num_points_;
  IndexedVector<OrderPlace, std::uint64_t> positions_;  // in the texture, of the pixels that come first
};

class CsvPointsWriter : public PointsWriter {
  using PointsWriter::PointsWriter;

  void write_rows() override {
    std::string text;
    for (int axis = 0; axis < job().extents.num_axes(); ++axis) text += job().extents.name(axis) + ",";
    text += "place\n";
    for_each_row([&](const std::vector<std::int64_t>& row) {
      fmt::format_to(std::back_inserter(text), "{}\n", fmt::join(row, ","));
      if (text.size() < piece_bytes) return;
      append(text);
      text.clear();
    });
    append(text);
  }
};

class NpyPointsWriter : public PointsWriter {
  using PointsWriter::PointsWriter;

  void write_rows() override {
    const std::vector<std::int64_t> shape = {num_rows(), num_columns()};
    append(npy_int64_header(shape));
    std::vector<std::int64_t> numbers;
    for_each_row([&](const std::vector<std::int64_t>& row) {
      numbers.insert(numbers.end(), row.begin(), row.end());
      if (numbers.size() * sizeof(std::int64_t) < piece_bytes) return;
      append(std::as_bytes(std::span(numbers)));
      numbers.clear();
    });
    append(std::as_bytes(std::span(numbers)));
  }
};

}  // namespace

std::unique_ptr<ContainerWriter> make_csv_points_writer(OutputFiles& files) {
  return std::make_unique<CsvPointsWriter>(files);
}
std::unique_ptr<ContainerWriter> make_npy_points_writer(OutputFiles& files) {
  return std::make_unique<NpyPointsWriter>(files);
}

}  // namespace noiseloom
