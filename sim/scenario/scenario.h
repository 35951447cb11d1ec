// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "sim/base/error.h"
#include "sim/base/geometry.h"
#include "sim/scenario/choices.h"
#include "sim/scenario/glenoid_settings.h"
#include "sim/scenario/motion_settings.h"

namespace reamsim {

// A scenario as plain, validated values. Only the parser reads YAML. Members have the names of the YAML keys, with
// units; defaults here are the documented ones. Paths are absolute after parsing.

// ---- bone ------------------------------------------------------------------------------------------------------

struct DensitySettings {  ///< HU to density; see DensityMapping
  double ash_slope_g_cm3_per_hu = 0.0007;
  double ash_offset_g_cm3 = -0.009;
  double ash_fraction = 0.6;

  friend bool operator==(const DensitySettings&, const DensitySettings&) = default;
};

/// Shapes for verification, and the parametric glenoid. Which keys apply: docs/keys.md.
struct PhantomSettings {
  PhantomShape shape = PhantomShape::glenoid;
  double density_g_cm3 = 1.8;  ///< half_space, cup, sphere: uniform
  Vec3 size_mm{40, 40, 20};    ///< half_space, cup, layered: the block; its top face is z = 0
  double radius_mm = 20;       ///< sphere; cup: radius of the spherical cup
  double cup_depth_mm = 4;     ///< cup
  double cortical_mm = 2;      ///< layered: thickness of the top layer
  double cortical_density_g_cm3 = 1.8;
  double trabecular_density_g_cm3 = 0.4;
  // glenoid; sources of its densities: docs/glenoid.md
  double subchondral_density_g_cm3 = 1.1;
  double height_mm = 35;           ///< superior–inferior
  double width_mm = 26;            ///< anterior–posterior, of the lower, wider part
  double face_radius_mm = 32;      ///< radius of curvature of the concave face
  double vault_depth_mm = 28;      ///< from face to neck
  double subchondral_mm = 2.0;     ///< plate under the face, 1.2–2.9
  double shell_mm = 1.4;           ///< cortical wall of the vault
  double version_deg = 0;          ///< retroversion positive
  double inclination_deg = 0;      ///< superior tilt positive
  double trabecular_gradient = 1;  ///< how much denser trabecular bone is under the plate than deep; 0: even
  double texture = 0.25;           ///< relative amplitude of the trabecular texture
  int seed = 1;
  // glenoid, worn or dysplastic; docs/glenoid.md defines the keys of each type
  Walch walch = Walch::none;       ///< sets defaults of some keys (apply_walch_defaults)
  double medialization_mm = 1.5;   ///< A1, A2: how far wear has moved the face's centre towards the trigonum spinae
  double wear_radius_mm = 24;      ///< A1, A2, B2: of the humeral head that wore the face
  double wear_direction_deg = 30;  ///< B2: direction of the wear from the centre, from posterior towards inferior
  double wear_ridge_mm = 0;        ///< B2: where the worn part begins, from the centre in that direction
  double wear_tilt_deg = 15;       ///< B2: of the worn part against the axis of the native face
  double rim_rounding_mm = 12;     ///< C: width of the posteroinferior rim that is rounded off
};

struct CutSphereSettings {
  Vec3 center_mm = Vec3::Zero();
  double radius_mm = 0;
};
struct CutPlaneSettings {
  Vec3 point_mm = Vec3::Zero();
  Vec3 normal = Vec3::UnitZ();  ///< what lies on this side is removed
};

struct LabelMapSettings {
  std::string path;
  std::vector<std::string> label{"1"};  ///< whole numbers or names of segments; several are one bone
  double refine_mm = 0;  ///< the mask's surface moves to the isosurface of refine_hu within this distance
  double refine_hu = 200;
  bool fill = false;  ///< bone without a label that the label surrounds becomes bone
};

/// Radiodensity from the values of a scan, beside the scale of the file: HU = slope · value + intercept.
struct HuSettings {
  double slope = 1;
  double intercept = 0;
};

struct CtSettings {
  std::string path;                  ///< DICOM folder, NRRD, NIfTI or MetaImage
  std::optional<HuSettings> hu{};    ///< of values that are no HU
  std::string series{};              ///< of a DICOM folder, and its volume (docs/inputs.md); "" = the largest
  Modality modality = Modality::ct;  ///< what a DICOM series may be
  Uneven uneven = Uneven::refuse;    ///< DICOM slices whose spacing changes
  std::optional<Vec3> crop_min_mm{};
  std::optional<Vec3> crop_max_mm{};
  CtFilter filter = CtFilter::none;
  int median_radius_voxels = 1;
  int anisotropic_iterations = 5;
  double anisotropic_conductance = 3;
  double threshold_hu = 200;
  double psf_mm = 0;  ///< full width of the point spread; 0: the voxel spacing along each axis
  double closing_mm = 1.5;
  bool fill_holes = true;
  std::optional<Vec3> seed_mm{};       ///< the piece that contains it is kept; without it the largest
  Separate separate = Separate::none;  ///< humerus: its head is found next to the glenoid and cut off
  std::vector<CutSphereSettings> cut_spheres{};
  std::vector<CutPlaneSettings> cut_planes{};
  std::optional<LabelMapSettings> label_map{};  ///< instead of threshold, closing, filling, seed and cuts
};

struct MeshBoneSettings {
  std::string path;
  double scale = 1;  ///< file units to mm
  MeshFrame frame = MeshFrame::file;
  double cortical_mm = 1.5;
  double cortical_hu = 1500;
  double trabecular_hu = 300;
  bool repair = false;
  double repair_change_percent = 1;  ///< the most by which a repair may change the volume
};

struct VdbBoneSettings {
  std::string path;
};

struct PilotHoleSettings {
  double diameter_mm = 2.5;
  Vec3 entry_mm = Vec3::Zero();
  Vec3 axis{0, 0, -1};  ///< direction of drilling
  double depth_mm = 20;
  PoseFrame frame = PoseFrame::bone;  ///< the frame of entry_mm and axis
};

struct BoneSettings {
  BoneSource source = BoneSource::phantom;
  BodySide side = BodySide::unknown;  ///< left | right; required where a glenoid frame is, unless a VDB knows it
  static constexpr double kLeastVoxel_mm = 0.01, kMostVoxel_mm = 5;
  double voxel_mm = 0.25;
  bool cache = true;  ///< keep the loaded bone on disk for the next command (sim/scene/bone_store.h)
  SurfaceVoxels surface_voxels = SurfaceVoxels::automatic;  ///< see with_surface_voxels()
  DensitySettings density{};
  GlenoidSettings glenoid{};
  PhantomSettings phantom{};
  CtSettings ct{};
  MeshBoneSettings mesh{};
  VdbBoneSettings vdb{};
  std::optional<PilotHoleSettings> pilot_hole{};
};

// ---- engine, cutting ---------------------------------------------------------------------------------------------

/// Settings that change speed and no result. They are not keys of a scenario: the benchmark and the tests set them.
struct EngineTuning {
  KernelShape kernel_shape = KernelShape::automatic;  ///< of the engines exact and bricked
  bool culling = true;                                ///< bricked skips cells of shell points that cannot touch bone
  bool windows = true;                                ///< exact uses windows of smooth motion; false: frame by frame
  int work_group_size = 0;                            ///< 0: chosen by the device
  int compute_units = 0;                              ///< of the device; 0: all
};

struct EngineSettings {
  EngineKind type = EngineKind::automatic;  ///< see engine_of()
  std::string device = "auto";              ///< auto | serial | part of PLATFORM: NAME of an OpenCL device
  int batch_frames = 64;                    ///< frames whose results are read back at once
  double max_step_voxels = 0.5;             ///< longest motion of any point of the tool in a substep
  EngineTuning tuning;
};

/// A point of the table of specific energy over density.
struct SpecificEnergySettings {
  double density_g_cm3 = 1;
  double energy_j_mm3 = 0.05;
};

/// u·(reference/h)^exponent, h the chip's thickness, kept within least and most.
struct SizeEffectSettings {
  double exponent = 0.3;
  double reference_mm = 0.05;  ///< chip thickness at which the specific energy is as it is without the size effect
  double least_mm = 0.001;
  double most_mm = 0.5;
  int cutting_edges = 1;

  friend bool operator==(const SizeEffectSettings&, const SizeEffectSettings&) = default;
};

/// Force per length of cutting edge in contact.
struct EdgeForceSettings {
  double tangential_n_mm = 1;
  double normal_n_mm = 0;
  int cutting_edges = 1;

  friend bool operator==(const EdgeForceSettings&, const EdgeForceSettings&) = default;
};

struct CuttingSettings {
  CuttingLaw law = CuttingLaw::energy;
  ErosionMode erosion = ErosionMode::exact;
  EnergyPreset preset = EnergyPreset::none;
  std::vector<SpecificEnergySettings> specific_energy_table{};  ///< empty: the power law
  double specific_energy_j_mm3 = 0.15;
  double reference_density_g_cm3 = 1.8;
  double density_exponent = 2;
  double normal_ratio = 0.5;
  double friction_fraction = 0;  ///< of the tangential force
  std::optional<SizeEffectSettings> size_effect{};
  std::optional<EdgeForceSettings> edge_force{};
  double speed_floor_mm_s = 10;
  double force_per_point_n = 0.001;  ///< law: per_point
  double wear_g_cm3_per_s = 80;      ///< erosion: wear; density that a touched voxel loses per second
};

/// `bone` with `surface_voxels: auto` resolved: partial for exact erosion, else whole.
inline BoneSettings with_surface_voxels(BoneSettings bone, const CuttingSettings& cutting) {
  if (bone.surface_voxels == SurfaceVoxels::automatic)
    bone.surface_voxels = cutting.erosion == ErosionMode::exact ? SurfaceVoxels::partial : SurfaceVoxels::whole;
  return bone;
}

// ---- render, output ----------------------------------------------------------------------------------------------

/// A camera of the user's own, drawn beside those in `cameras`.
struct UserCamera {
  std::string name;                   ///< ends the names of its files
  PoseFrame frame = PoseFrame::bone;  ///< of position, target and up
  Vec3 position_mm = Vec3::Zero();
  std::optional<Vec3> target_mm;  ///< middle of the picture; without it the glenoid, or the reamed region
  std::optional<Vec3> up;         ///< without it superior
  Projection projection = Projection::perspective;
  double fov_deg = 30;   ///< perspective: of the picture's height
  double width_mm = 60;  ///< orthographic: of the picture
};

struct RenderSettings {
  bool enabled = true;
  RenderContext context = RenderContext::automatic;
  int width_px = 1920;
  int height_px = 1080;
  int frame_height_px = 540;  ///< of pictures along the run, of the same proportions; at most height_px
  int every_frames = 0;       ///< 0: as picture_frames() spreads them
  /// The first names the files without a suffix.
  std::vector<CameraView> cameras{CameraView::oblique, CameraView::glenoid, CameraView::section};
  std::vector<UserCamera> user_cameras;
  bool before_after = true;
  bool contact_sheet = true;
  int turntable_pictures = 0;  ///< round the superior axis; 0 = none
  FilmFormat film = FilmFormat::none;
  int film_rate_hz = 25;
  bool tool = true;
  ToolMaterial tool_material = ToolMaterial::see_through;
  bool force_arrow = true;  ///< in pictures along the run
  Background background = Background::studio;
  Vec3 light{-0.55, 0.70, 0.62};  ///< direction to the key light: right, up, towards the viewer
  int supersampling = 1;          ///< pictures are rendered at this multiple of the size, and averaged
  bool report = true;             ///< write report.html beside the pictures
  double depth_max_mm = 0;        ///< top of the depth legend; 0: the predicted depth
};

struct OutputSettings {
  std::string dir;  ///< "" = out/NAME, with the name of the scenario, below the working folder
  bool vti = true;
  bool segmentation = false;
  bool meshes = true;
  bool plots = true;
  bool force_basis = false;
  double checkpoint_s = 60;  ///< wall time between two checkpoints of a run; 0: none
};

/// Frames of a run, both ends included.
struct FrameSpan {
  std::int64_t first = 0;
  std::int64_t last = 0;

  friend bool operator==(const FrameSpan&, const FrameSpan&) = default;
};

/// Ascending, of the passes that touch the bone; none: not known, or no contact.
using FrameSpans = std::vector<FrameSpan>;

/// Frames of which a snapshot is kept for pictures, ascending: 0, `last` and, between, every n-th. Without a number in
/// the settings these are evenly spaced: for a film or without contact along the run, else in contact.
std::vector<std::int64_t> picture_frames(const RenderSettings& settings, std::int64_t last, const FrameSpans& contact);

/// Of `frames` (ascending), those in contact with a margin of 5 %; all of them if there are not two of these.
std::vector<std::int64_t> in_contact(const std::vector<std::int64_t>& frames, const FrameSpans& contact);

/// At most `most` (2 or more) of `frames` (ascending), evenly distributed, with the first and the last.
std::vector<std::int64_t> evenly_among(const std::vector<std::int64_t>& frames, std::size_t most);

/// Of the frames with a snapshot, those of still pictures: all, or where a film has set their number the first, the
/// last, and others in contact.
std::vector<std::int64_t> still_frames(const std::vector<std::int64_t>& frames, const RenderSettings& settings,
                                       const FrameSpans& contact);

/// The place of each key in the file, by path ("motion.keyframes.0.time_s"); of a missing key that of its section.
class KeyLocations {
 public:
  void set(const std::string& path, const SourceLocation& where, bool given) { places_[path] = {where, given}; }
  [[nodiscard]] SourceLocation of(const std::string& path) const {
    const auto found = places_.find(path);
    return found == places_.end() ? SourceLocation{} : found->second.where;
  }
  /// Whether the file (or --set) has the key.
  [[nodiscard]] bool given(const std::string& path) const {
    const auto found = places_.find(path);
    return found != places_.end() && found->second.given;
  }
  /// Adds the place of the key to mistakes that name a key and no place, as those that the loaded data show.
  [[nodiscard]] InputError located(const InputError& error) const {
    std::vector<Mistake> mistakes = error.mistakes();
    for (Mistake& mistake : mistakes) {
      if (mistake.where.file.empty() && !mistake.key.empty()) mistake.where = of(mistake.key);
    }
    return InputError(std::move(mistakes));
  }
  /// Throws an InputError at a key: `found`, "expected " and `expected`.
  [[noreturn]] void fail(const std::string& key, const std::string& found, const std::string& expected) const {
    throw InputError(of(key), key, found, "expected " + expected);
  }

 private:
  struct Place {
    SourceLocation where;
    bool given = false;
  };
  std::map<std::string, Place> places_;
};

/// A key whose points come from a markups file of 3D Slicer (sim/scenario/markups.h). Its value is that of the numbers.
struct MarkupsSource {
  std::string key;    ///< as for KeyLocations
  std::string path;   ///< absolute
  std::string found;  ///< for a note: which points, and the frame of the file
};

/// The version of the format that is written. Version 1 is read as well.
constexpr int kScenarioVersion = 2;

struct Scenario {
  int version = kScenarioVersion;
  std::string name;   ///< key `name`; without it the file's stem
  std::string file;   ///< absolute path of the YAML
  KeyLocations keys;  ///< their places in it, for messages
  BoneSettings bone;
  ToolSettings tool;
  ClearanceSettings clearance;
  MotionSettings motion;
  EngineSettings engine;
  CuttingSettings cutting;
  MetricSettings metrics;
  RenderSettings render;
  OutputSettings output;
  std::vector<MarkupsSource> markups;
  std::vector<std::string> notes;  ///< keys of older versions of the format that were migrated or have no effect
};

/// The engine that runs: `engine.type`, with `auto` decided by the erosion.
inline EngineKind engine_of(const Scenario& scenario) {
  if (scenario.engine.type != EngineKind::automatic) return scenario.engine.type;
  return scenario.cutting.erosion == ErosionMode::exact ? EngineKind::exact : EngineKind::bricked;
}

}  // namespace reamsim
