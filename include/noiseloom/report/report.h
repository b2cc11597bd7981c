// A page about one texture: self-contained HTML (pictures inside, no scripts, nothing from a network).
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace noiseloom {

struct ReportFigure {
  std::string html;     // an <img> or <svg>
  std::string caption;  // plain text
  int width = 0;        // CSS pixels, at most page_width; 0: what is left of the row
};

// A line of a table; `command` stands under it, in the letters of a terminal, over the whole width.
struct ReportTableRow {
  std::vector<std::string> cells;
  std::string command;
  bool strong = false;
};

// The first column holds words, those after it numbers (aligned to the right); `last_is_text`: the last one words.
struct ReportTable {
  std::vector<std::string> columns;
  std::vector<ReportTableRow> rows;
  bool last_is_text = false;
};

struct ReportSection {
  std::string title;
  std::string text;  // plain text, may be empty
  std::vector<ReportFigure> figures;
  std::vector<ReportTable> tables = {};
};

struct ReportRow {
  std::string name;
  std::string value;
};

// A filter and R under it, for the table with bars.
struct ReportScore {
  std::string filter;
  double relative_error;
};

// What the page was made by. Empty members are left out.
struct ReportOrigin {
  std::string version;
  std::string date;
  std::string command;
};

struct Report {
  std::string title;
  std::string subtitle;
  std::vector<std::pair<std::string, std::string>> headline;  // number, what it is
  std::vector<std::string> findings;  // sentences, the first one the largest; the summary then comes last
  std::vector<ReportRow> summary;
  std::vector<ReportScore> scores;
  std::vector<ReportSection> sections;
  std::string config;  // TOML; may be empty
  ReportOrigin origin = {};
};

std::string base64(std::span<const std::byte> bytes);

// "data:image/png;base64,...": what an image in a page may name as its source.
std::string embedded_source(std::span<const std::byte> png);
// An <img> of so many pixels that holds the PNG. The figure that it is put in must have the same width: a picture of
// noise that is scaled by anything but a whole number shows patterns that are not in the texture.
std::string embedded_png(std::span<const std::byte> png, int width, int height, const std::string& alternative_text);

// The widest figure that a page shows as it is.
inline constexpr int page_width = 914;

std::string report_html(const Report& report);

}  // namespace noiseloom
