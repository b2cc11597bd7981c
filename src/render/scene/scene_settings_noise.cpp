// Settings of [[noise]].
#include "noiseloom/samples/space.h"
#include "render/scene/scene_settings.h"

namespace noiseloom::render {
namespace {

// In the order of NoiseKind.
constexpr Word noise_words[] = {
    {"file", "a run file, images, or arrays: what score reads", "image texture png run"},
    {"config", "made by generate from a config, once: kept in the output folder", "generate toml"},
    {"white", "independent random numbers", "random uniform whitenoise"},
    {"blue-2d", "slices that are blue each alone, by void and cluster", "2dbn blue void-and-cluster"},
    {"blue-3d", "one volume that is blue as a whole", "3dbn"},
    {"golden-ratio", "one blue slice, moved on by the golden ratio every frame", "gr golden phi"},
    {"ign", "interleaved gradient noise", "interleaved-gradient jimenez"},
    {"sobol-owen", "in every pixel a Sobol sequence over the frames, with an Owen scramble of its own",
     "sobol owen owen-sobol"},
    {"sobol-rotated", "in every pixel the same Sobol sequence, rotated by a white random offset",
     "cranley-patterson sobol-rotation"},
    {"heitz-belcour", "a seed for each pixel, moved behind every frame so that errors follow another noise",
     "hb seeds"},
    {"tables", "a sequence with keys of each pixel, as Heitz and others made them: arrays in source text",
     "hb-ldbn low-discrepancy-sampler ranking scrambling"},
    {"sobol-blue",
     "a Sobol sequence with keys of each pixel that are made here, so that errors are blue after 1, 2, 4, ... frames",
     "blue-sobol keys"},
};

// In the order of ValuesFrom.
constexpr Word read_words[] = {{"offsets", "one slice, at the offsets of the R2 sequence", "r2"},
                               {"slices", "the slices that follow", "time frames"}};

constexpr settings::Condition with_kind(std::string_view words) { return {"noise[].kind", words}; }

std::vector<Word> words_of_samples() {
  std::vector<Word> words;
  for (const SampleSpace* space : sample_spaces())
    words.push_back({space->traits().name, space->traits().meaning, space->traits().aliases});
  return words;
}

}  // namespace

std::vector<Setting> rows_of_noises() {
  static const std::vector<Word> samples = words_of_samples();
  return {
      {.key = "noise",
       .type = Type::tables,
       .sentence = "What the same picture is rendered with.",
       .field = [](Scene& s) -> Field { return &s.noises; },
       .required = true,
       .example = "{ kind = \"white\" }"},
      {.key = "noise[].kind",
       .type = Type::word,
       .sentence = "Where the numbers come from.",
       .field = [](NoiseSpec& n) -> Field { return &n.kind; },
       .words = noise_words,
       .required = true},
      {.key = "noise[].name",
       .type = Type::text,
       .sentence = "What tables and expectations call it; the word of its kind where it is not said.",
       .field = [](NoiseSpec& n) -> Field { return &n.name; },
       .zero_is_unset = true},
      {.key = "noise[].file",
       .type = Type::file,
       .sentence = "Relative to the scene. Of kind file: a run file, an image, an array, a folder of images, or a "
                   "pattern such as \"ours_{}.png\"; of kind tables: source text with the arrays sobol_256spp_256d, "
                   "scramblingTile and, where it has it, rankingTile.",
       .field = [](NoiseSpec& n) -> Field { return &n.file; },
       .when = with_kind("file config tables"),
       .required = true,
       .is_found_by_reader = true},
      {.key = "noise[].set",
       .type = Type::text,
       .sentence = "Changes of the config, as --set of generate takes them: [\"texture.seed=2\"].",
       .field = [](NoiseSpec& n) -> Field { return &n.changes; },
       .list = true,
       .when = with_kind("config")},
      {.key = "noise[].samples",
       .type = Type::word,
       .sentence = "What the values of a file are that does not say so itself.",
       .field = [](NoiseSpec& n) -> Field { return &n.samples; },
       .words = samples,
       .when = with_kind("file")},
      {.key = "noise[].values",
       .type = Type::word,
       .sentence = "Where a pixel reads its second and further numbers in a frame.",
       .field = [](NoiseSpec& n) -> Field { return &n.values_from; },
       .words = read_words,
       .when = with_kind("file config blue-2d blue-3d")},
      {.key = "noise[].size",
       .type = Type::integer,
       .sentence = "Width and height of the texture.",
       .field = [](NoiseSpec& n) -> Field { return &n.size; },
       .range = at_least(1, 1024),
       .unit = "pixels",
       .when = with_kind("blue-2d blue-3d golden-ratio")},
      {.key = "noise[].slices",
       .type = Type::integer,
       .sentence = "Slices of the texture, or frames after which golden-ratio and ign begin again.",
       .field = [](NoiseSpec& n) -> Field { return &n.slices; },
       .range = at_least(1, 65536),
       .when = with_kind("blue-2d blue-3d golden-ratio ign")},
      {.key = "noise[].seed",
       .type = Type::integer,
       .sentence = "Another seed gives other numbers.",
       .field = [](NoiseSpec& n) -> Field { return &n.seed; },
       .range = at_least(0),
       .when = with_kind("white blue-2d blue-3d golden-ratio sobol-owen sobol-rotated heitz-belcour sobol-blue")},
      {.key = "noise[].target",
       .type = Type::text,
       .sentence = "The noise of the scene, a texture, that errors are to follow, by its name.",
       .field = [](NoiseSpec& n) -> Field { return &n.target; },
       .when = with_kind("heitz-belcour"),
       .required = true},
      {.key = "noise[].block",
       .type = Type::integer,
       .sentence = "Width and height of the blocks of pixels within which seeds are moved in a frame.",
       .field = [](NoiseSpec& n) -> Field { return &n.block; },
       .range = at_least(2, 64),
       .unit = "pixels",
       .when = with_kind("heitz-belcour")},
      {.key = "noise[].retarget",
       .type = Type::integer,
       .sentence =
           "How far seeds are carried, at most, when the mask of the next frame is another, so that they follow "
           "it as they followed this one; 0: not.",
       .field = [](NoiseSpec& n) -> Field { return &n.retarget; },
       .range = at_least(0, 16),
       .unit = "pixels",
       .when = with_kind("heitz-belcour")},
      {.key = "noise[].points",
       .type = Type::integer,
       .sentence = "Frames whose mean has blue errors, a power of two; so have all powers of two below.",
       .field = [](NoiseSpec& n) -> Field { return &n.points; },
       .range = at_least(1, 256),
       .when = with_kind("sobol-blue")},
      {.key = "noise[].numbers",
       .type = Type::integer,
       .sentence = "Numbers of an estimate, one or two, for which keys are made together.",
       .field = [](NoiseSpec& n) -> Field { return &n.numbers; },
       .range = at_least(1, 2),
       .when = with_kind("sobol-blue")},
      {.key = "noise[].importance",
       .type = Type::boolean,
       .sentence = "Whether convolution and sky bend its numbers to where the kernel or the light is; else they are "
                   "spread evenly, and what is found is weighed. Textures that hold such points are taken as they are.",
       .field = [](NoiseSpec& n) -> Field { return &n.importance; }},
  };
}

}  // namespace noiseloom::render
