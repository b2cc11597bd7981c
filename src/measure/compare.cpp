#include "noiseloom/measure/compare.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "noiseloom/core/json.h"
#include "noiseloom/core/quantity_text.h"
#include "noiseloom/image/naming.h"
#include "noiseloom/measure/quality.h"
#include "noiseloom/samples/sample_space.h"

namespace noiseloom {
namespace {

struct Measured {
  std::vector<std::string> rows;
  std::vector<double> values;
};

Measured measured(const TextureFile& file, const FilterSpec& own, ThreadPool& pool) {
  const Texture& texture = file.texture;
  const DistanceKind kind = distance_kind(file.config->problem.samples, texture.channels);
  Measured found;
  std::vector<FilterSpec> filters = {own};
  for (const FilterSpec& filter : standard_filters(texture.extents)) filters.push_back(filter);
  const double mean = mean_distance_of(texture, kind, pool);
  for (const FilterSpec& filter : filters) {
    const std::string row = "R, " + describe_filter(texture.extents, filter);
    if (std::find(found.rows.begin(), found.rows.end(), row) != found.rows.end()) continue;
    found.rows.push_back(row);
    found.values.push_back(relative_error_of(texture, kind, filter, mean, pool));
  }
  for (const GroupQuality& group : spectral_quality(texture, kind, &own).groups) {
    if (!std::isfinite(group.low_frequency_power)) continue;
    found.rows.push_back(fmt::format("power below {} over {}", low_frequency, group.name));
    found.values.push_back(group.low_frequency_power);
  }
  return found;
}

// The samples of a slice in an order that does not depend on where they lie.
std::vector<std::vector<float>> sorted_samples(const Texture& texture, SliceIndex slice) {
  const auto channels = static_cast<std::size_t>(texture.channels);
  const std::vector<float> interleaved = interleaved_slice(texture, slice);
  std::vector<std::vector<float>> samples;
  for (std::size_t i = 0; i < interleaved.size(); i += channels)
    samples.emplace_back(interleaved.begin() + static_cast<std::ptrdiff_t>(i),
                         interleaved.begin() + static_cast<std::ptrdiff_t>(i + channels));
  std::sort(samples.begin(), samples.end());
  return samples;
}

std::string permutation_text(const Texture& first, const Texture& other) {
  if (!(first.extents == other.extents) || first.channels != other.channels) return "of another size";
  const std::int32_t slices = first.extents.num_slices();
  std::int32_t same = 0;
  for (const SliceIndex s : first.extents.slices())
    same += sorted_samples(first, s) == sorted_samples(other, s) ? 1 : 0;
  if (same == slices)
    return first.values == other.values ? "the same texture" : "every slice holds the same samples in another order";
  return same == 0 ? "no slice holds the same samples"
                   : fmt::format("{} of {} slices hold the same samples", same, slices);
}

std::string cell(double mean, double error) {
  return error > 0 ? fmt::format("{} +- {}", digits_text(mean), digits_text(error)) : digits_text(mean);
}

// A cell of CSV (RFC 4180).
std::string csv_cell(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + '"';
}
std::string csv_number(double value) { return std::isnan(value) ? "" : fmt::format("{}", value); }

// As the cell of a table: what the format takes for its own is escaped.
std::string escaped(const std::string& text, bool latex) {
  std::string result;
  for (const char c : text) {
    if (latex && c == '\\') {
      result += "\\textbackslash{}";
    } else if (latex && (c == '~' || c == '^')) {
      result += fmt::format("\\{}{{}}", c);
    } else {
      if (latex ? std::string_view("_%&#${}").find(c) != std::string_view::npos : c == '|') result += '\\';
      result += c;
    }
  }
  return result;
}

}  // namespace

Comparison compare(const std::vector<CompareColumn>& columns, ThreadPool& pool) {
  const TextureFile& first = columns.front().textures.front();
  const RunConfig& config = *first.config;
  Comparison comparison;
  for (const CompareColumn& column : columns) {
    ComparedTexture compared{column.name, column.files, {}, {}};
    std::vector<std::vector<double>> all;
    for (std::size_t t = 0; t < column.textures.size(); ++t) {
      const TextureFile& file = column.textures[t];
      const SampleSpec& samples = file.config->problem.samples;
      if (samples.space != config.problem.samples.space ||
          distance_kind(samples, file.texture.channels) !=
              distance_kind(config.problem.samples, first.texture.channels))
        throw UserError(column.files[t],
                        fmt::format("holds samples \"{}\", {} \"{}\": R of different samples is no comparison",
                                    describe_samples(samples), columns.front().files.front(),
                                    describe_samples(config.problem.samples)));
      if (file.texture.extents.num_axes() != first.texture.extents.num_axes())
        throw UserError(column.files[t], fmt::format("{}, but {} is {}: axes differ", file.texture.extents.to_string(),
                                                     columns.front().files.front(), first.texture.extents.to_string()));
      const Measured found = measured(file, config.problem.filter, pool);
      if (comparison.rows.empty()) comparison.rows = found.rows;
      // A row that one of them has not is left empty.
      std::vector<double> values;
      for (const std::string& row : comparison.rows) {
        const auto at = std::find(found.rows.begin(), found.rows.end(), row) - found.rows.begin();
        values.push_back(at < std::ssize(found.rows) ? found.values[static_cast<std::size_t>(at)] : std::nan(""));
      }
      all.push_back(values);
    }
    const auto n = static_cast<double>(all.size());
    for (std::size_t row = 0; row < comparison.rows.size(); ++row) {
      double sum = 0;
      for (const std::vector<double>& values : all) sum += values[row];
      double squares = 0;
      for (const std::vector<double>& values : all) squares += (values[row] - sum / n) * (values[row] - sum / n);
      compared.means.push_back(sum / n);
      compared.errors.push_back(n > 1 ? std::sqrt(squares / (n - 1) / n) : 0);
    }
    comparison.textures.push_back(compared);
    if (&column != &columns.front())
      comparison.permutations.push_back(permutation_text(first.texture, column.textures.front().texture));
  }
  return comparison;
}

std::string comparison_table(const Comparison& comparison, const std::string& format) {
  std::string text;
  if (format == "csv") {
    text = "measure";
    for (const ComparedTexture& t : comparison.textures)
      text += ',' + csv_cell(t.name) + ',' + csv_cell(t.name + " standard error");
    text += "\n";
    for (std::size_t row = 0; row < comparison.rows.size(); ++row) {
      text += csv_cell(comparison.rows[row]);
      for (const ComparedTexture& t : comparison.textures)
        text += ',' + csv_number(t.means[row]) + ',' + csv_number(t.errors[row]);
      text += "\n";
    }
    return text;
  }
  const bool latex = format == "latex";
  const char* const between = latex ? " & " : " | ";
  const char* const end = latex ? " \\\\\n" : " |\n";
  text = latex ? fmt::format("\\begin{{tabular}}{{l{}}}\n", std::string(comparison.textures.size(), 'r')) : "| ";
  for (const ComparedTexture& t : comparison.textures) text += between + escaped(t.name, latex);
  text += end;
  text += latex ? "\\hline\n" : "|---|";
  for (std::size_t t = 0; t < comparison.textures.size() && !latex; ++t) text += "---:|";
  if (!latex) text += "\n";
  for (std::size_t row = 0; row < comparison.rows.size(); ++row) {
    text += (latex ? "" : "| ") + escaped(comparison.rows[row], latex);
    for (const ComparedTexture& t : comparison.textures) {
      std::string value = cell(t.means[row], t.errors[row]);
      if (const std::size_t at = value.find("+-"); latex && at != std::string::npos) value.replace(at, 2, "$\\pm$");
      text += between + value;
    }
    text += end;
  }
  return latex ? text + "\\end{tabular}\n" : text;
}

std::string comparison_json(const Comparison& comparison) {
  std::string columns;
  for (std::size_t t = 0; t < comparison.textures.size(); ++t) {
    const ComparedTexture& texture = comparison.textures[t];
    std::string files;
    for (const std::string& file : texture.files) files += (files.empty() ? "" : ", ") + json_string(file);
    std::string values;
    for (std::size_t row = 0; row < comparison.rows.size(); ++row)
      values += fmt::format("{}{}: {{\"mean\": {}, \"standard_error\": {}}}", row == 0 ? "" : ", ",
                            json_string(comparison.rows[row]), json_number(texture.means[row]),
                            json_number(texture.errors[row]));
    columns += fmt::format(
        "{}{{\"name\": {}, \"files\": [{}], \"measures\": {{{}}}{}}}", t == 0 ? "" : ", ", json_string(texture.name),
        files, values,
        t == 0 ? "" : fmt::format(", \"beside_the_first\": {}", json_string(comparison.permutations[t - 1])));
  }
  return "{\"textures\": [" + columns + "]}";
}

}  // namespace noiseloom
