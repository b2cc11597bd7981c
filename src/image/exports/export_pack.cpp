#include "noiseloom/image/export_pack.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <memory>
#include <optional>

#include "image/facts/provenance.h"
#include "image/facts/stored_number.h"
#include "noiseloom/config/stored_config.h"
#include "noiseloom/files/generations.h"
#include "noiseloom/files/order_codec.h"
#include "noiseloom/files/output_files.h"

namespace noiseloom {
namespace {

constexpr std::string_view pack_letters = "RGBA";

struct Source {
  std::string path;
  std::string stem;
  RunFileReader reader;
  RunConfig config;
  int dataset = 0;
  std::optional<ValueRange> range;
  std::vector<float> slice = {};  // [y][x][channel]

  int channels() const { return reader.content().datasets[static_cast<std::size_t>(dataset)].channels; }
};

// What a channel of the file holds.
struct Content {
  int source = -1;  // -1: a number
  int channel = 0;
  double number = 0;
};

Source open_source(const std::string& path) {
  RunFileReader reader = open_to_look_at(path);
  require_finished_order(reader.content(), path);
  RunConfig config = stored_config(reader.content(), path);
  const int dataset = reader.dataset("/samples");
  return {path,    std::filesystem::path(path).stem().string(), std::move(reader), config,
          dataset, natural_range(config.problem.samples)};
}

class Packing {
 public:
  explicit Packing(const std::vector<Source>& sources) : sources_(sources) {}

  std::vector<Content> parse(const std::string& text) {
    std::vector<std::optional<Content>> channels(pack_letters.size());
    for (std::size_t at = 0; at <= text.size();) {
      const std::size_t end = std::min(text.find(',', at), text.size());
      parse_item(text.substr(at, end - at), channels);
      at = end + 1;
    }
    std::vector<Content> contents;
    for (const std::optional<Content>& channel : channels) {
      if (!channel) break;
      contents.push_back(*channel);
    }
    const auto given = std::count_if(channels.begin(), channels.end(), [](const auto& c) { return c.has_value(); });
    if (given != std::ssize(contents))
      fault(fmt::format("--pack {}: accepted channels: R, RG, RGB or RGBA, none left out", text));
    check_sizes();
    throw_if_any(std::move(faults_));
    return contents;
  }

 private:
  void fault(const std::string& text) { faults_.push_back({"command line", text}); }

  std::string stems() const {
    std::string list;
    for (const Source& source : sources_) list += (list.empty() ? "" : ", ") + source.stem;
    return list;
  }

  void parse_item(const std::string& item, std::vector<std::optional<Content>>& channels) {
    const std::size_t equals = item.find('=');
    const std::string left = item.substr(0, equals);
    if (equals == std::string::npos || left.empty() || left.find_first_not_of(pack_letters) != std::string::npos)
      return fault(fmt::format("--pack {}: must be channels, =, and what they hold: RG=NAME, B=NAME.0, A=1", item));
    const std::vector<Content> contents = contents_of(item.substr(equals + 1), left, item);
    for (std::size_t i = 0; i < std::min(left.size(), contents.size()); ++i) {
      std::optional<Content>& channel = channels[pack_letters.find(left[i])];
      if (channel) fault(fmt::format("--pack {}: {} is given twice", item, left[i]));
      channel = contents[i];
    }
  }

  // As many as there are letters; none where there is a fault.
  std::vector<Content> contents_of(const std::string& right, const std::string& left, const std::string& item) {
    const auto named = [&](const std::string& stem) {
      return std::find_if(sources_.begin(), sources_.end(), [&](const Source& s) { return s.stem == stem; }) -
             sources_.begin();
    };
    const auto count = std::ssize(sources_);
    const std::size_t dot = right.rfind('.');
    int channel = -1;
    auto source = named(right);
    if (source == count && dot != std::string::npos && parse(right.substr(dot + 1), channel))
      source = named(right.substr(0, dot));
    double number = 0;
    if (source == count && parse(right, number)) {
      if (!(number >= 0 && number <= 1)) fault(fmt::format("--pack {}: a number must be from 0 to 1", item));
      return std::vector<Content>(left.size(), {-1, 0, number});
    }
    if (source == count) {
      fault(fmt::format(
          "--pack {}: \"{}\" is no run file that was named; accepted: {}, one of their channels (NAME.0), or a "
          "number from 0 to 1",
          item, right, stems()));
      return {};
    }
    const int found = sources_[static_cast<std::size_t>(source)].channels();
    if (channel >= found || (channel >= 0 && left.size() != 1) ||
        (channel < 0 && std::cmp_not_equal(found, left.size()))) {
      fault(fmt::format("--pack {}: {} has {} channel{}; name as many, or one of them ({}.0)", item,
                        sources_[static_cast<std::size_t>(source)].path, found, found == 1 ? "" : "s",
                        sources_[static_cast<std::size_t>(source)].stem));
      return {};
    }
    std::vector<Content> contents;
    for (int c = 0; std::cmp_less(c, left.size()); ++c)
      contents.push_back({static_cast<int>(source), channel < 0 ? c : channel, 0});
    return contents;
  }

  template <class Number>
  static bool parse(const std::string& text, Number& number) {
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    return error == std::errc{} && end == text.data() + text.size();
  }

  void check_sizes() {
    const Extents& first = sources_.front().reader.content().extents;
    for (const Source& source : sources_) {
      const Extents& extents = source.reader.content().extents;
      if (!(extents == first))
        faults_.push_back({source.path, fmt::format("{}, but {} is {}: textures that are packed have one size",
                                                    extents.to_string(), sources_.front().path, first.to_string())});
      if (&source != &sources_.front() && source.stem == sources_.front().stem)
        faults_.push_back({source.path, fmt::format("is called {} as {} is: --pack cannot tell them apart", source.stem,
                                                    sources_.front().path)});
    }
  }

  const std::vector<Source>& sources_;
  std::vector<Fault> faults_;
};

// A run file of as many channels as are packed, for the planner; its numbers are of 0 to 1.
ExportPlan plan_packed(const std::vector<Source>& sources, const std::vector<Content>& contents,
                       const ExportOptions& options) {
  const Source& first = sources.front();
  RunFileContent content;
  content.extents = first.reader.content().extents;
  content.datasets = {{"/samples", ElementType::float32, static_cast<int>(contents.size()), true}};
  ProblemSpec problem = first.config.problem;
  problem.samples = {};
  problem.samples.space = contents.size() == 1 ? "uniform" : fmt::format("vector{}", contents.size());
  return plan_export("packed", content, problem, options);
}

Facts packed_facts(const std::vector<Source>& sources, const std::vector<Content>& contents, bool integers) {
  Facts facts;
  for (std::size_t c = 0; c < contents.size(); ++c) {
    const std::string letter(1, pack_letters[c]);
    if (contents[c].source < 0) {
      facts.emplace_back(letter, fmt::format("{}", contents[c].number));
      continue;
    }
    const Source& source = sources[static_cast<std::size_t>(contents[c].source)];
    std::string text = fmt::format("channel {} of {}; {}", contents[c].channel, source.stem,
                                   facts_line(facts_of(source.reader.content(), source.config)));
    if (integers && source.range)
      text += fmt::format("; 0 to 1 stand for {} to {}", source.range->lo, source.range->hi);
    facts.emplace_back(letter, text);
  }
  for (const Source& source : sources) facts.emplace_back("config of " + source.stem, source.reader.content().config);
  return facts;
}

class PackedSlices {
 public:
  PackedSlices(std::vector<Source>& sources, const std::vector<Content>& contents, const ExportOutput& output)
      : sources_(sources), contents_(contents), output_(output) {}

  std::span<const std::byte> slice(SliceIndex s) {
    const Extents& extents = sources_.front().reader.content().extents;
    const auto cells = static_cast<std::size_t>(extents.cells_per_slice());
    for (Source& source : sources_) {
      source.slice.resize(cells * static_cast<std::size_t>(source.channels()));
      source.reader.read_slice(source.dataset, s, std::as_writable_bytes(std::span(source.slice)));
    }
    const std::size_t bytes = bytes_per_number(output_.type);
    const std::vector<int>& pixel = output_.pixel.source;
    bytes_.resize(cells * pixel.size() * bytes);
    for (std::size_t cell = 0; cell < cells; ++cell)
      for (std::size_t c = 0; c < pixel.size(); ++c)
        store_number(number_of(pixel[c], cell), output_.type, is_below_one(pixel[c]),
                     bytes_.data() + (cell * pixel.size() + c) * bytes);
    return bytes_;
  }

 private:
  double number_of(int place, std::size_t cell) const {
    if (place == zero_channel) return 0;
    if (place == opaque_channel) return 1;
    const Content& content = contents_[static_cast<std::size_t>(place)];
    if (content.source < 0) return content.number;
    const Source& source = sources_[static_cast<std::size_t>(content.source)];
    const double value = static_cast<double>(
        source.slice[cell * static_cast<std::size_t>(source.channels()) + static_cast<std::size_t>(content.channel)]);
    return is_integer(output_.type) && source.range ? to_unit(*source.range, value) : value;
  }
  bool is_below_one(int place) const {
    if (place < 0) return false;
    const Content& content = contents_[static_cast<std::size_t>(place)];
    return content.source >= 0 && sources_[static_cast<std::size_t>(content.source)].range == ValueRange{};
  }

  std::vector<Source>& sources_;
  const std::vector<Content>& contents_;
  const ExportOutput& output_;
  std::vector<std::byte> bytes_;
};

}  // namespace

ExportResult export_packed(const std::vector<std::string>& paths, const std::string& packing,
                           const ExportOptions& options, FileOps& ops) {
  std::vector<Source> sources;
  for (const std::string& path : paths) sources.push_back(open_source(path));
  const std::vector<Content> contents = Packing(sources).parse(packing);
  const ExportPlan plan = plan_packed(sources, contents, options);
  const ExportOutput& output = plan.outputs.front();
  for (const Content& content : contents)
    if (content.source >= 0 && is_integer(output.type) && !sources[static_cast<std::size_t>(content.source)].range)
      throw UserError(sources[static_cast<std::size_t>(content.source)].path,
                      "its samples have no fixed range, which integers stand for: accepted here: --depth 16f, 32f");
  OutputFiles files(ops, options.overwrite);
  files.check(output.targets);

  ContainerJob job;
  job.source = paths.front();
  job.extents = plan.extents;
  output.describe(job, plan.num_slices());
  job.range = plan.range;
  job.samples = "packed";
  job.decoding = is_integer(output.type)
                     ? fmt::format("(b + 0.5) / {}", output.type == PixelType::uint8    ? "256"
                                                     : output.type == PixelType::uint16 ? "65536"
                                                                                        : "4294967296")
                     : "number stored";
  job.holds_samples = false;
  job.facts = packed_facts(sources, contents, is_integer(output.type));
  job.description = "packed sampling noise, " + packing;
  const std::unique_ptr<ContainerWriter> writer = output.container->make(files);
  PackedSlices slices(sources, contents, output);
  for (std::size_t f = 0; f < output.targets.size(); ++f) {
    job.first_slice = SliceIndex(plan.begin + narrow<std::int32_t>(f));
    writer->begin(output.targets[f], job);
    for (const SliceIndex s : job.slices()) writer->slice(s, slices.slice(s));
    writer->end();
  }
  ExportResult result;
  result.files = files.targets();
  files.commit();
  return result;
}

}  // namespace noiseloom
