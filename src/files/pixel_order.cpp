#include "noiseloom/files/pixel_order.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstring>
#include <limits>

namespace noiseloom {
namespace {

constexpr int most_decimals = 18;
constexpr std::uint64_t not_seen = std::numeric_limits<std::uint64_t>::max();

bool is_digit(char c) { return c >= '0' && c <= '9'; }

// Digits with at most one point among them, then perhaps an exponent; false where the text is nothing of the kind.
bool read_decimal(const std::string& text, DecimalFraction& fraction, bool& fits) {
  std::size_t at = 0;
  int digits = 0;
  bool point = false;
  fits = true;
  for (; at < text.size() && (is_digit(text[at]) || (text[at] == '.' && !point)); ++at) {
    if (text[at] == '.') {
      point = true;
      continue;
    }
    ++digits;
    if (fraction.numerator == 0 && text[at] == '0') {
      fraction.decimals += point ? 1 : 0;
      continue;
    }
    fits = fits && fraction.numerator < 100'000'000'000'000'000U;  // 18 digits at most
    if (fits) fraction.numerator = 10 * fraction.numerator + static_cast<std::uint64_t>(text[at] - '0');
    fraction.decimals += point ? 1 : 0;
  }
  if (digits == 0) return false;
  if (at == text.size()) return true;
  int exponent = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data() + at + 1, end, exponent);
  if ((text[at] != 'e' && text[at] != 'E') || error != std::errc{} || stop != end || std::abs(exponent) > 1000)
    return false;
  fraction.decimals -= exponent;
  return true;
}

}  // namespace

std::int64_t DecimalFraction::floor_of_times(std::int64_t count) const {
  __extension__ using Wide = unsigned __int128;  // 10^18 times 2^63 fits
  Wide power = 1;
  for (int i = 0; i < decimals; ++i) power *= 10;
  return static_cast<std::int64_t>(Wide{numerator} * static_cast<std::uint64_t>(count) / power);
}

DecimalFraction parse_fraction(const std::string& what, const std::string& text) {
  DecimalFraction fraction;
  bool fits = true;
  const auto refuse = [&](const std::string& why) {
    throw UserError("command line", fmt::format("{} {}: {}", what, text, why));
  };
  if (!read_decimal(text, fraction, fits)) refuse("must be a number above 0 and at most 1, such as 0.1");
  while (fraction.numerator > 0 && fraction.numerator % 10 == 0) {
    fraction.numerator /= 10;
    --fraction.decimals;
  }
  // A number that keeps a last digit other than 0 before the point is 1 or more; only 1 itself is accepted.
  const bool is_one = fraction.numerator == 1 && fraction.decimals == 0;
  if (fraction.numerator == 0 || (fraction.decimals <= 0 && !is_one)) refuse("must be above 0 and at most 1");
  if (!fits || fraction.decimals > most_decimals) refuse(fmt::format("has more than {} decimals", most_decimals));
  std::uint64_t one = 1;
  for (int i = 0; i < fraction.decimals; ++i) one *= 10;
  if (fraction.numerator > one) refuse("must be above 0 and at most 1");
  return fraction;
}

std::string why_no_order(const RunFileContent& content) {
  const auto found = std::ranges::find(content.datasets, "/order", &SliceDataset::name);
  if (found == content.datasets.end())
    return "holds no /order, the sequence of its pixels: only masks of method \"void-and-cluster\" have one";
  if (found->type == ElementType::float32 || found->channels != 1)
    return "/order is no list of ranks (uint32 or uint64, one a pixel)";
  return "";
}

PixelOrder::PixelOrder(const RunFileReader& reader, const std::string& path)
    : reader_(reader), path_(path), dataset_(reader.dataset("/order")) {
  if (const std::string why = why_no_order(reader.content()); !why.empty()) throw UserError(path, why);
  require_all_ranked();
}

void PixelOrder::read_slice(SliceIndex slice, std::span<std::uint64_t> ranks) const {
  const SliceDataset& dataset = reader_.content().datasets[static_cast<std::size_t>(dataset_)];
  if (dataset.type == ElementType::uint64) {
    reader_.read_slice(dataset_, slice, std::as_writable_bytes(ranks));
    return;
  }
  std::vector<std::uint32_t> narrow_ranks(ranks.size());
  reader_.read_slice(dataset_, slice, std::as_writable_bytes(std::span(narrow_ranks)));
  std::copy(narrow_ranks.begin(), narrow_ranks.end(), ranks.begin());
}

// Pixels without a rank hold values that no rank has (construct/void_and_cluster.h).
void PixelOrder::require_all_ranked() const {
  const Extents& extents = reader_.content().extents;
  std::vector<std::uint64_t> ranks(static_cast<std::size_t>(extents.cells_per_slice()));
  std::int64_t num_ranked = 0;
  for (SliceIndex s = 0; s < extents.num_slices(); ++s) {
    read_slice(s, ranks);
    num_ranked += std::count_if(ranks.begin(), ranks.end(), [&](std::uint64_t rank) {
      return rank < static_cast<std::uint64_t>(extents.num_cells());
    });
  }
  if (num_ranked < extents.num_cells())
    throw UserError(path_, fmt::format("not finished: {} of {} pixels have their place in the order; go on with "
                                       "generate --resume",
                                       num_ranked, extents.num_cells()));
}

std::vector<std::uint64_t> PixelOrder::first_pixels(std::int64_t count) const {
  const Extents& extents = reader_.content().extents;
  const std::size_t cells = static_cast<std::size_t>(extents.cells_per_slice());
  std::vector<std::uint64_t> positions(static_cast<std::size_t>(count), not_seen);
  std::vector<std::uint64_t> ranks(cells);
  for (SliceIndex s = 0; s < extents.num_slices(); ++s) {
    read_slice(s, ranks);
    for (std::size_t cell = 0; cell < cells; ++cell)
      if (ranks[cell] < positions.size()) positions[ranks[cell]] = cell + cells * static_cast<std::size_t>(s);
  }
  // As many ranks as pixels, none too large: where one occurs twice, one is missing.
  const auto missing = std::find(positions.begin(), positions.end(), not_seen);
  if (missing != positions.end())
    throw UserError(path_,
                    fmt::format("/order is no sequence of the pixels: none has rank {}", missing - positions.begin()));
  return positions;
}

}  // namespace noiseloom
