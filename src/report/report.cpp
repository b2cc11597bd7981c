#include "noiseloom/report/report.h"

#include <fmt/format.h>

#include <algorithm>

#include "noiseloom/report/number_text.h"
#include "noiseloom/report/plot.h"

namespace noiseloom {
namespace {

// The page is 1000 pixels wide, of which a figure has page_width. Pictures are shown pixel by pixel; where the window
// is too narrow for that they are scaled smoothly. Nothing is drawn inside an image's box, which would scale it too.
constexpr const char* page_style = R"(
:root { color-scheme: light dark; --ink: #1d2430; --soft: #5d6778; --line: #dfe3ea; --page: #f6f7f9; --card: #fff;
  --accent: #2f7ed8; }
@media (prefers-color-scheme: dark) { :root { --ink: #e6e9ef; --soft: #9aa4b5; --line: #333a46; --page: #14171c;
  --card: #1c2027; } }
* { box-sizing: border-box; }
html { background: var(--page); }
body { margin: 0; background: var(--page); color: var(--ink); font: 15px/1.5 system-ui, sans-serif; }
main { max-width: 1000px; margin: 0 auto; padding: 32px 20px 60px; }
h1 { margin: 0; font-size: 26px; overflow-wrap: anywhere; }
h2 { margin: 0 0 4px; font-size: 18px; }
p { margin: 4px 0 12px; color: var(--soft); max-width: 75ch; }
section { background: var(--card); border: 1px solid var(--line); border-radius: 10px; padding: 20px 22px;
  margin-top: 18px; }
.headline { display: flex; flex-wrap: wrap; gap: 14px; margin-top: 20px; }
.headline div { flex: 1 1 200px; background: var(--card); border: 1px solid var(--line); border-radius: 10px;
  padding: 14px 20px; }
.headline b { display: block; font-size: 30px; font-weight: 650; line-height: 1.2; }
.headline span { color: var(--soft); }
.figures { display: flex; flex-wrap: wrap; gap: 22px; align-items: flex-start; }
figure { margin: 0; max-width: 100%; overflow-x: auto; }
figure.wide { flex: 1 1 465px; min-width: min(465px, 100%); }
figure img { display: block; max-width: 100%; height: auto; box-shadow: 0 0 0 1px var(--line); }
figure svg { display: block; width: 100%; min-width: 465px; height: auto; color: var(--ink) !important; }
figure svg.nl-picture { min-width: 0; }
@media (min-width: 1040px) { figure img, .nl-picture image { image-rendering: pixelated; } }
figcaption { color: var(--soft); font-size: 13px; margin-top: 6px; max-width: 70ch; }
table { border-collapse: collapse; width: 100%; }
th, td { text-align: left; vertical-align: top; padding: 5px 14px 5px 0; border-top: 1px solid var(--line); }
tr:first-child > * { border-top: 0; }
th { font-weight: 500; color: var(--soft); white-space: nowrap; width: 1%; }
td { overflow-wrap: anywhere; font-variant-numeric: tabular-nums; }
.bar { width: 45%; } .bar i { display: block; height: 10px; margin-top: 7px; border-radius: 3px; background: var(--accent); }
td.number { width: 1%; white-space: nowrap; }
.findings p { color: inherit; margin: 6px 0; max-width: none; } .findings p:first-child { font-size: 19px; font-weight: 600; line-height: 1.35; margin-bottom: 12px; }
.wide-table { overflow-x: auto; } .figures + .wide-table { margin-top: 18px; }
.data th { width: auto; font-size: 13px; border-bottom: 1px solid var(--line); vertical-align: bottom; }
.data th, .data td { text-align: right; } .data td { white-space: nowrap; }
.data th:first-child, .data td:first-child { text-align: left; white-space: normal; }
.data .words { text-align: left; padding: 5px 0 5px 14px; white-space: normal; }
.data .strong td { font-weight: 650; }
.data tr.command td { border-top: 0; padding: 0 0 8px; text-align: left; white-space: normal; }
code { font: 12px/1.45 ui-monospace, Menlo, Consolas, monospace; color: var(--soft); overflow-wrap: anywhere; }
.choices { color: var(--soft); font-size: 13px; } .choices span { display: inline-block; min-width: 3em; }
.choices label { margin-right: 12px; white-space: nowrap; color: var(--ink); }
.right-picture, .left-picture { background: var(--right) no-repeat; image-rendering: pixelated; }
.right-picture { position: relative; margin-top: 8px; box-shadow: 0 0 0 1px var(--line); }
.left-picture { background-image: var(--left); width: 50%; height: 100%; min-width: 18px; max-width: 100%; overflow: hidden;
  resize: horizontal; border-right: 2px solid var(--accent); }
pre { overflow-x: auto; margin: 8px 0 0; font-size: 13px; }
footer { margin-top: 18px; color: var(--soft); font-size: 13px; }
@page { margin: 12mm; }
@media print {
  :root { color-scheme: light; --ink: #000; --soft: #444; --line: #bbb; --page: #fff; --card: #fff; }
  * { print-color-adjust: exact; -webkit-print-color-adjust: exact; }
  body { font-size: 13px; } figcaption, footer, pre { font-size: 12px; }
  main { max-width: none; padding: 0; }
  section { border: 0; border-top: 1px solid var(--line); border-radius: 0; padding: 14px 0 0; }
  h2, h2 + p, tr:first-child { break-after: avoid; } tr:last-child { break-before: avoid; }
  figure, tr, section > p, .headline { break-inside: avoid; }
  .figures { zoom: .8; } figure img { box-shadow: none; }
  figure, .wide-table, pre { overflow: visible; }
  figure.wide { flex-basis: 100%; } figure svg { min-width: 0; }
  pre { white-space: pre-wrap; }
}
)";

std::string summary_table(const std::vector<ReportRow>& rows) {
  std::string html = "<section>\n<table>\n";
  for (const ReportRow& row : rows)
    html += fmt::format("<tr><th>{}</th><td>{}</td></tr>\n", xml_escaped(row.name), xml_escaped(row.value));
  return html + "</table>\n</section>\n";
}

std::string score_table(const std::vector<ReportScore>& scores) {
  double longest = 1;
  for (const ReportScore& score : scores) longest = std::max(longest, score.relative_error);
  std::string html =
      "<section>\n<h2>Under other filters</h2>\n<p>R of the whole texture, as at the top of the page, but after each "
      "of these filters; white noise has 1. Noise made for one filter is seldom the best for another.</p>\n<table>\n";
  for (const ReportScore& score : scores)
    html += fmt::format(
        "<tr><td>{}</td><td class='number'>{}</td><td class='bar'><i style='width:{:.1f}%'></i></td>"
        "</tr>\n",
        xml_escaped(score.filter), error_text(score.relative_error),
        100 * std::clamp(score.relative_error / longest, 0.0, 1.0));
  return html + "</table>\n</section>\n";
}

std::string data_table(const ReportTable& table) {
  const auto cell = [&](const char* tag, std::size_t column, const std::string& text) {
    const bool words = table.last_is_text && column + 1 == table.columns.size();
    return fmt::format("<{0}{1}>{2}</{0}>", tag, words ? " class='words'" : "", xml_escaped(text));
  };
  std::string html = "<div class='wide-table'><table class='data'>\n<tr>";
  for (std::size_t c = 0; c < table.columns.size(); ++c) html += cell("th", c, table.columns[c]);
  html += "</tr>\n";
  for (const ReportTableRow& row : table.rows) {
    html += row.strong ? "<tr class='strong'>" : "<tr>";
    for (std::size_t c = 0; c < row.cells.size(); ++c) html += cell("td", c, row.cells[c]);
    html += "</tr>\n";
    if (!row.command.empty())
      html += fmt::format("<tr class='command'><td colspan='{}'><code>{}</code></td></tr>\n", table.columns.size(),
                          xml_escaped(row.command));
  }
  return html + "</table></div>\n";
}

std::string section_html(const ReportSection& section) {
  std::string html = fmt::format("<section>\n<h2>{}</h2>\n", xml_escaped(section.title));
  if (!section.text.empty()) html += fmt::format("<p>{}</p>\n", xml_escaped(section.text));
  if (!section.figures.empty()) html += "<div class='figures'>\n";
  for (const ReportFigure& figure : section.figures)
    html += fmt::format("<figure{}>{}<figcaption>{}</figcaption></figure>\n",
                        figure.width > 0 ? fmt::format(" style='width:{}px'", figure.width) : " class='wide'",
                        figure.html, xml_escaped(figure.caption));
  if (!section.figures.empty()) html += "</div>\n";
  for (const ReportTable& table : section.tables) html += data_table(table);
  return html + "</section>\n";
}

std::string findings_html(const std::vector<std::string>& findings) {
  if (findings.empty()) return "";
  std::string html = "<section class='findings'>\n";
  for (const std::string& sentence : findings) html += fmt::format("<p>{}</p>\n", xml_escaped(sentence));
  return html + "</section>\n";
}

std::string origin_html(const ReportOrigin& origin) {
  std::string text;
  const auto add = [&](const std::string& part) {
    if (!part.empty()) text += (text.empty() ? "" : ", ") + part;
  };
  add(origin.version.empty() ? "" : "noiseloom " + xml_escaped(origin.version));
  add(xml_escaped(origin.date));
  if (!origin.command.empty()) text += fmt::format("<br><code>{}</code>", xml_escaped(origin.command));
  return text.empty() ? "" : fmt::format("<footer>Made by {}</footer>\n", text);
}

}  // namespace

std::string base64(std::span<const std::byte> bytes) {
  constexpr char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    unsigned group = 0;
    for (std::size_t k = 0; k < 3; ++k) group = group << 8 | (k < count ? std::to_integer<unsigned>(bytes[i + k]) : 0U);
    for (std::size_t k = 0; k < 4; ++k) text += k <= count ? digits[group >> (18 - 6 * k) & 63U] : '=';
  }
  return text;
}

std::string embedded_source(std::span<const std::byte> png) { return "data:image/png;base64," + base64(png); }

std::string embedded_png(std::span<const std::byte> png, int width, int height, const std::string& alternative_text) {
  return fmt::format("<img alt='{}' width='{}' height='{}' src='{}'>", xml_escaped(alternative_text), width, height,
                     embedded_source(png));
}

std::string report_html(const Report& report) {
  std::string html = fmt::format(
      "<!DOCTYPE html>\n<html lang='en'>\n<head>\n<meta charset='utf-8'>\n"
      "<meta name='viewport' content='width=device-width, initial-scale=1'>\n<title>{}</title>\n<style>{}</style>\n"
      "</head>\n<body>\n<main>\n<h1>{}</h1>\n<p>{}</p>\n",
      xml_escaped(report.title), page_style, xml_escaped(report.title), xml_escaped(report.subtitle));
  html += "<div class='headline'>\n";
  for (const auto& [number, meaning] : report.headline)
    html += fmt::format("<div><b>{}</b><span>{}</span></div>\n", xml_escaped(number), xml_escaped(meaning));
  html += "</div>\n";
  if (report.findings.empty()) html += summary_table(report.summary);
  html += findings_html(report.findings);
  for (const ReportSection& section : report.sections) html += section_html(section);
  if (!report.findings.empty()) html += summary_table(report.summary);
  if (!report.scores.empty()) html += score_table(report.scores);
  if (!report.config.empty())
    html += fmt::format("<section>\n<h2>Config</h2>\n<pre>{}</pre>\n</section>\n", xml_escaped(report.config));
  html += origin_html(report.origin);
  return html + "</main>\n</body>\n</html>\n";
}

}  // namespace noiseloom
