#include "report/report_writer.h"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "report/wipe.h"

namespace noiseloom {
namespace {

constexpr int spectrum_size = 340;     // of a spectrum's longer side, in CSS pixels: a plot has room beside it
constexpr int most_frequencies = 768;  // along a side; of larger spectra, neighbours are averaged

}  // namespace

std::string ReportWriter::path(const std::string& file) const {
  return (std::filesystem::path(folder_) / file).string();
}

void ReportWriter::write(const std::string& file, const std::string& text) { output_.write(path(file), text); }

void ReportWriter::write_csv(const std::string& file, const std::vector<SpectrumBin>& bins) {
  std::string text = "frequency_cycles_per_pixel,power,count\n";
  for (const SpectrumBin& bin : bins) text += fmt::format("{},{},{}\n", bin.frequency, bin.power, bin.count);
  write(file, text);
}

std::vector<std::byte> ReportWriter::write_png(const std::string& file, const Picture& picture,
                                               const std::string& caption) {
  const std::string temporary = output_.add(path(file));
  write_picture(temporary, picture, caption);
  std::ifstream in(temporary, std::ios::binary);
  const std::vector<char> bytes{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  const auto* const begin = reinterpret_cast<const std::byte*>(bytes.data());
  return {begin, begin + bytes.size()};
}

ReportFigure ReportWriter::figure(const std::string& file, const Picture& picture, const std::string& caption) {
  NOISELOOM_CHECK_LE(picture.width, page_width);
  const std::vector<std::byte> png = write_png(file, picture, caption);
  return {embedded_png(png, picture.width, picture.height, caption), caption, picture.width};
}

ReportFigure ReportWriter::spectrum_figure(const std::string& file, const PlaneSpectrum& spectrum,
                                           const PictureAxes& axes, const std::string& caption) {
  const Picture small = spectrum_picture(spectrum, most_frequencies);
  const Picture picture =
      enlarged(small, factor_to_fill(small.width, spectrum_size), factor_to_fill(small.height, spectrum_size));
  const std::vector<std::byte> png = write_png(file, picture, caption);
  return {picture_with_axes(embedded_source(png), picture.width, picture.height, axes), caption,
          picture_width_with_axes(picture.width)};
}

ReportFigure ReportWriter::wipe(const std::string& prefix, const std::vector<std::pair<std::string, Picture>>& pictures,
                                const std::string& caption) {
  std::vector<std::pair<std::string, std::string>> sources;
  for (const auto& [name, picture] : pictures)
    sources.emplace_back(name, embedded_source(write_png(fmt::format("{}_{}.png", prefix, name), picture, name)));
  const Picture& first = pictures.front().second;
  return {wipe_html(fmt::format("wipe{}", ++num_wipes_), first.width, first.height, sources), caption, first.width};
}

void ReportWriter::finish() { write("report.html", report_html(report)); }

PlotLine line_of(const std::vector<SpectrumBin>& bins, const std::string& label, PlotLine::Style style) {
  PlotLine line{label, {}, {}, style};
  for (const SpectrumBin& bin : bins) {
    line.x.push_back(bin.frequency);
    line.y.push_back(bin.power);
  }
  return line;
}

PlotLine white_noise_line() { return {"white noise", {0, 0.5}, {1, 1}, PlotLine::Style::dashed}; }

}  // namespace noiseloom
