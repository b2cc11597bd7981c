// A report while it is put together: its page, and the files that lie beside it.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "noiseloom/files/output_files.h"
#include "noiseloom/measure/spectrum.h"
#include "noiseloom/report/picture.h"
#include "noiseloom/report/plot.h"
#include "noiseloom/report/report.h"

namespace noiseloom {

inline constexpr int plot_width = 640;  // CSS pixels of a plot that stands alone

class ReportWriter {
 public:
  ReportWriter(OutputFiles& output, const std::string& folder) : output_(output), folder_(folder) {}

  Report report;

  // Writes a file beside the page; each name once.
  void write(const std::string& file, const std::string& text);
  // A table of a spectrum: frequency, power, how many frequencies the power is the mean of.
  void write_csv(const std::string& file, const std::vector<SpectrumBin>& bins);
  // Writes the picture and returns it for the page, shown pixel by pixel: at most page_width wide.
  ReportFigure figure(const std::string& file, const Picture& picture, const std::string& caption);
  // The same for a spectrum: black is no power, light grey that of white noise, and both axes run from -1/2 to 1/2.
  ReportFigure spectrum_figure(const std::string& file, const PlaneSpectrum& spectrum, const PictureAxes& axes,
                               const std::string& caption);
  // Pictures of one size, with their names, laid over each other (wipe.h). They are written as PREFIX_NAME.png.
  ReportFigure wipe(const std::string& prefix, const std::vector<std::pair<std::string, Picture>>& pictures,
                    const std::string& caption);
  // Writes the page itself.
  void finish();

 private:
  std::string path(const std::string& file) const;
  // The PNG that was written.
  std::vector<std::byte> write_png(const std::string& file, const Picture& picture, const std::string& caption);

  OutputFiles& output_;
  std::string folder_;
  int num_wipes_ = 0;
};

// A spectrum as a line of a plot.
PlotLine line_of(const std::vector<SpectrumBin>& bins, const std::string& label, PlotLine::Style style);
// What every plot of power holds for comparison: power 1 from frequency 0 to 1/2.
PlotLine white_noise_line();

}  // namespace noiseloom
