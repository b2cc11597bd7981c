// What passes work on: data that all jobs share, and that of a job: one effect with one noise in one repeat, frame by
// frame. Jobs do not depend on each other, so that they run on any number of threads and give the same bytes.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "noiseloom/core/parallel.h"
#include "noiseloom/render/passes.h"
#include "noiseloom/render/result.h"
#include "render/jobs/mesh_pass.h"
#include "render/jobs/retarget.h"
#include "render/jobs/seeds.h"
#include "render/world/image.h"
#include "render/world/kernel.h"
#include "render/world/mesh.h"
#include "render/world/sky_light.h"
#include "render/world/surface.h"
#include "render/world/volume.h"

namespace noiseloom::render {

// Before and after every filter over space, in the order of the scene.
struct Truth {
  std::vector<Image> after;
  std::vector<double> bias = {};  // of each: rms distance from the converged truth
};

// Where the truth is another in every frame (a motion, an integrand that changes), a picture has twice its channels:
// the estimates, and behind them what these are on average. Both go through the same linear filters, so that the second
// half is what the first is measured against. What is not linear (a clamp, the a-trous filter) is done to estimates
// alone.

struct Shared {
  const Scene& scene;
  std::vector<Effect> effects;
  std::vector<Stage> stages;
  ThreadPool& pool;
  const std::vector<Noise>& opened;
  std::string_view pass = {};           // that is running
  Counts* counts = nullptr;             // of that pass
  std::vector<std::string> notes = {};  // what is to be known of what was made

  Made<const std::vector<Noise>*> noises = {};
  Made<Image> picture = {};
  Made<Grid> density = {};
  Made<Grid> light = {};
  Made<Columns> columns = {};
  Made<Flights> flights = {};
  Made<BlurMasses> kernel = {};
  Made<Image> importance = {};
  Made<SkyLight> sky = {};
  Made<std::vector<Image>> sky_truths = {};  // of frames, until the sky has turned around
  Made<std::unique_ptr<const Mesh>> mesh = {};
  Made<Shares> shares = {};
  Made<Hits> hits = {};
  Made<CarryingOfFrames> carrying = {};
  Made<std::vector<EdgeWeights>> edge_weights = {};  // of each filter over space; empty where it knows no edges
  Made<std::vector<std::vector<Truth>>> truth = {};  // [effect][repeat], one repeat where all have the same

  Made<std::vector<std::optional<double>>> predictions = {};  // [noise][stage]

  // The pass that runs, or where a job asks, that of the effect.
  std::string_view pass_or(std::string_view effect) const { return pass.empty() ? effect : pass; }
};

// Averages over the frames so far, one for each filter over time.
struct Averages {
  std::vector<Image> images;
  std::vector<std::vector<float>> squares;  // of brightness, where a filter is guided by its variance
  std::vector<double> sums;                 // mc: of all frames
  std::vector<int> lengths;                 // where pixels have histories of their own: frames in that of each
};

struct Pictures {
  std::vector<Image> after;   // [stage]
  std::vector<Image> truths;  // [stage], where they change with the frame
};

struct Job {
  const Shared& shared;
  std::size_t effect = 0;  // index into the scene's
  std::size_t noise = 0;
  int repeat = 0;
  std::int64_t frame = 0;
  std::string_view pass = {};
  Counts* counts = nullptr;
  Rows rows = {};  // on several threads where there are fewer jobs than these

  Made<Hits> moving_hits = {};  // of this frame
  Hits hits_before = {};        // and of the one before
  Made<Seeds> seeds = {};
  Made<Image> estimate = {};
  Made<Averages> accumulated = {};
  Made<std::vector<Image>> filtered = {};     // [filter over time, the frame alone first][filter over space]
  Made<std::vector<std::uint8_t>> seen = {};  // pixels of which any frame so far has a sample
  Made<std::vector<double>> errors = {};      // [metric][stage][frame], of roots the squares
  Made<Pictures> pictures = {};               // of the last frame
  Made<std::vector<Texture>> stacks = {};     // [filter over time]: errors of all frames before filters over space
  std::vector<ErrorSpectrum> spectra = {};    // of these

  const Scene& scene() const { return shared.scene; }
  const Noise& noise_of_job() const { return (*shared.noises.get(Data::noises, pass))[noise]; }
  // The picture after the filters of a stage.
  const Image& after(std::size_t stage) const;
  // Of its channels, those that are estimates.
  int channels() const;
  // Plane `channel` of what a stage is measured against.
  const float* truth_plane(std::size_t stage, int channel) const;
};

}  // namespace noiseloom::render
