// What a texture looks like and how its error is spread over frequencies: pictures, tables and report.html.
#pragma once

#include <string>
#include <vector>

#include "noiseloom/core/parallel.h"
#include "noiseloom/files/output_files.h"
#include "noiseloom/image/texture_file.h"
#include "noiseloom/measure/quality.h"
#include "noiseloom/report/report.h"

namespace noiseloom {

// Adds to `output`, in `folder`:
//   report.html            everything on one page
//   preview.png            the first slice; slice_S.png: the first slices, where there are several
//   error.png, error_white_noise.png, estimates.png    with a config: what its filter leaves (filtered.h)
//   spectrum_xy.png .csv .svg    power over the frequencies of a slice; table and plot: averaged over rings
//   spectrum_xT.png, spectrum_T.csv    for every slice axis T (by its name) longer than 1; spectrum_xT.csv where the
//                          filter groups x with T
//   spectrum_AB.png .csv    for other axes A, B that the filter groups; three and more: the table alone
//   spectra.svg             the power over all those, on a logarithmic scale
//   points_D.png            run files with /order: the points at some densities D, first slice
//   convergence.csv        run files: their history
// `name` is shown as title, `origin` at the end of the page. Scores need a config and are left out without one. Returns
// what it found.
SpectralQuality analyze_texture(const std::string& name, const TextureFile& file, const std::string& folder,
                                OutputFiles& output, ThreadPool& pool, const ReportOrigin& origin = {});

}  // namespace noiseloom
