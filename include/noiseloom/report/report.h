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
  int width = 0;        // CSS pixels; 0: what is left of the row
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

struct Report {
  std::string title;
  std::string subtitle;
  std::vector<std::pair<std::string, std::string>> headline;  // number, what it is
  std::vector<std::string> findings;  // sentences, the first one the largest; the summary then comes last
  std::vector<ReportRow> summary;
  std::vector<ReportScore> scores;
  std::vector<ReportSection> sections;
  std::string config;  // TOML; may be empty
};

std::string base64(std::span<const std::byte> bytes);

// An <img> that holds the PNG, as wide as the figure it is in, without smoothing.
std::string embedded_png(std::span<const std::byte> png, const std::string& alternative_text);

std::string report_html(const Report& report);

}  // namespace noiseloom
