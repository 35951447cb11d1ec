// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "seeds.h"

#include <openvdb/openvdb.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <set>

#include "sim/bone/bone.h"
#include "sim/bone/vdb/bone_vdb.h"
#include "sim/mesh/mesh_io.h"
#include "sim/scene/load_bone.h"
#include "tests/scan/dicom_bytes.h"
#include "tests/scan/test_images.h"
#include "tests/support/mesh_shapes.h"

namespace reamsim::test {

namespace {

namespace fs = std::filesystem;

/// Small, so that many fit into a second: a block of bone of 6 mm in 8×8×6 voxels.
TestImage small_image() {
  TestImage image;
  image.dims = Vec3i(8, 8, 6);
  image.spacing_mm = Vec3(1, 1, 1.25);
  image.sample([](const Vec3& p) { return (p - Vec3(3.5, 3.5, 3)).cwiseAbs().maxCoeff() < 2.6 ? 500.0 : 0.0; });
  return image;
}

class SeedWriter {
 public:
  explicit SeedWriter(std::string root) : root_(std::move(root)) {}

  /// A seed of one file, which `write` makes at a path.
  template <class Write>
  void add(const std::string& reader, const std::string& name, const Write& write) {
    Seed seed = start(reader);
    seed.files = {name};
    seed.named = name;
    write(seed.folder + "/" + name);
    seed.bone = bone_from_file(seed.folder + "/" + name);
    add(std::move(seed));
  }
  void add_text(const std::string& reader, const std::string& name, const std::string& text) {
    add(reader, name, [&](const std::string& path) { std::ofstream(path, std::ios::binary) << text; });
  }
  /// A folder for a seed.
  Seed start(const std::string& reader) {
    Seed seed;
    seed.reader = reader;
    seed.folder = root_ + "/" + std::to_string(seeds_.size());
    fs::create_directories(seed.folder);
    return seed;
  }
  void add(Seed seed) {
    seed.read = [bone = seed.bone](const std::string&) { load(bone); };
    seeds_.push_back(std::move(seed));
  }
  std::vector<Seed> take() { return std::move(seeds_); }

 private:
  std::string root_;
  std::vector<Seed> seeds_;
};

constexpr const char* kPlyBox =
    "ply\nformat ascii 1.0\ncomment a box\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n"
    "element face 6\nproperty list uchar int vertex_indices\nend_header\n"
    "0 0 0\n6 0 0\n0 6 0\n6 6 0\n0 0 6\n6 0 6\n0 6 6\n6 6 6\n"
    "4 0 2 3 1\n4 4 5 7 6\n4 0 1 5 4\n4 2 6 7 3\n4 0 4 6 2\n4 1 3 7 5\n";
constexpr const char* kObjBox =
    "# a box\nmtllib none.mtl\no box\nv 0 0 0\nv 6 0 0\nv 0 6 0\nv 6 6 0\nv 0 0 6\nv 6 0 6\nv 0 6 6\nv 6 6 6\n"
    "vn 0 0 1\nvt 0 0\ng sides\nf 1//1 3//1 4//1 2//1\nf 5/1 6/1 8/1 7/1\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
constexpr const char* kVtpBox =
    "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" byte_order=\"LittleEndian\" "
    "header_type=\"UInt32\">\n<PolyData>\n"
    "<FieldData><Array type=\"String\" Name=\"SPACE\" format=\"ascii\">76 80 83 0</Array></FieldData>\n"
    "<Piece NumberOfPoints=\"8\" NumberOfPolys=\"6\">\n"
    "<Points><DataArray type=\"Float32\" NumberOfComponents=\"3\" format=\"appended\" offset=\"0\"/></Points>\n"
    "<Polys><DataArray type=\"Int32\" Name=\"connectivity\" format=\"ascii\">\n"
    "0 2 3 1 4 5 7 6 0 1 5 4 2 6 7 3 0 4 6 2 1 3 7 5</DataArray>\n"
    "<DataArray type=\"Int32\" Name=\"offsets\" format=\"ascii\">4 8 12 16 20 24</DataArray></Polys>\n"
    "</Piece>\n</PolyData>\n<AppendedData "
    "encoding=\"base64\">\n_"
    "YAAAAAAAAAAAAAAAAAAAAAAAwEAAAAAAAAAAAAAAAAAAAMBAAAAAAAAAwEAAAMBAAAAAAAAAAAAAAAAAAADAQAAAwEAAAAAA"
    "AADAQAAAAAAAAMBAAADAQAAAwEAAAMBAAADAQA==\n</AppendedData>\n</VTKFile>\n";

std::string ascii_stl() {
  std::string out = "solid box\n";
  const TriangleMesh box = box_mesh({0, 0, 0}, {6, 6, 6});
  for (const auto& triangle : box.triangles) {
    out += "facet normal 0 0 0\nouter loop\n";
    for (const Vec3& p : box.corners(triangle)) {
      out += "vertex " + std::to_string(p.x()) + " " + std::to_string(p.y()) + " " + std::to_string(p.z()) + "\n";
    }
    out += "endloop\nendfacet\n";
  }
  return out + "endsolid box\n";
}

std::string binary_ply() {
  std::string out =
      "ply\nformat binary_little_endian 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 12\nproperty list uchar int vertex_indices\nend_header\n";
  const TriangleMesh box = box_mesh({0, 0, 0}, {6, 6, 6});
  for (const Vec3& p : box.vertices) {
    const Eigen::Vector3f narrow = p.cast<float>();
    out.append(reinterpret_cast<const char*>(narrow.data()), 3 * sizeof(float));
  }
  for (const auto& triangle : box.triangles) {
    out += '\3';
    out.append(reinterpret_cast<const char*>(triangle.data()), 3 * sizeof(std::int32_t));
  }
  return out;
}

void add_meshes(SeedWriter& writer) {
  writer.add("STL", "box.stl", [](const std::string& path) { write_stl(path, box_mesh({0, 0, 0}, {6, 6, 6})); });
  writer.add_text("STL, text", "text.stl", ascii_stl());
  writer.add_text("PLY, text", "text.ply", kPlyBox);
  writer.add_text("PLY", "box.ply", binary_ply());
  writer.add_text("OBJ", "box.obj", kObjBox);
  writer.add_text("VTP", "box.vtp", kVtpBox);
}

void add_images(SeedWriter& writer) {
  const TestImage image = small_image();
  const auto image_seed = [&](const std::string& reader, const std::string& name, bool compressed) {
    writer.add(reader, name, [&](const std::string& path) { write_image<std::int16_t>(image, path, compressed); });
  };
  image_seed("NRRD", "raw.nrrd", false);
  image_seed("NRRD, gzip", "gzip.nrrd", true);
  image_seed("NIfTI", "plain.nii", false);
  image_seed("NIfTI, gzip", "gzip.nii.gz", true);
  image_seed("MetaImage", "plain.mha", false);
  image_seed("MetaImage, zlib", "zlib.mha", true);
  image_seed("NRRD, detached", "header.nhdr", false);
  image_seed("MetaImage, detached", "header.mhd", false);
  // The NIfTI library reads a file that is not compressed under this name too.
  writer.add("NIfTI, contents of gzip", "stored.nii.gz", [&](const std::string& path) {
    const fs::path plain = fs::path(path).parent_path() / "plain.nii";
    write_image<std::int16_t>(image, plain.string());
    fs::rename(plain, path);
  });
}

void add_labels(SeedWriter& writer) {
  const TestImage image = small_image();
  TestImage labels = image;
  for (double& value : labels.value) value = value > 0 ? 1 : 0;
  const std::map<std::string, std::string> formats{
      {"labels.seg.nrrd", "NRRD"}, {"labels.nii", "NIfTI"}, {"labels.dcm", "DICOM SEG"}};
  for (const auto& [name, format] : formats) {
    Seed seed = writer.start("label map, " + format);
    write_image<std::int16_t>(image, seed.folder + "/scan.nrrd");
    const std::string path = seed.folder + "/" + name;
    if (name == "labels.nii") {
      write_image<std::uint8_t>(labels, path);
    } else if (name == "labels.dcm") {
      std::ofstream(path, std::ios::binary) << dicom_seg({{.label = "bone", .mask = labels}});
    } else {
      write_seg_nrrd({labels}, path,
                     "Segment0_ID:=a\nSegment0_Name:=bone\nSegment0_LabelValue:=1\nSegment0_Layer:=0\n");
    }
    seed.files = {name};
    seed.named = seed.folder;  // a valid map may leave no bone of the scan, which is then named
    seed.bone = bone_from_file(seed.folder + "/scan.nrrd");
    seed.bone.ct.label_map = LabelMapSettings{.path = path, .label = {"1"}};
    writer.add(std::move(seed));
  }
}

void add_dicom(SeedWriter& writer, bool enhanced) {
  Seed seed = writer.start(enhanced ? "DICOM, enhanced" : "DICOM");
  if (enhanced) {
    fs::create_directory(seed.folder + "/series");
    std::ofstream(seed.folder + "/series/frames.dcm", std::ios::binary) << enhanced_ct({small_image()}, {});
  } else {
    write_dicom(small_image(), seed.folder + "/series");
  }
  for (const auto& file : fs::directory_iterator(seed.folder + "/series")) {
    seed.files.push_back("series/" + file.path().filename().string());
  }
  std::ranges::sort(seed.files);
  seed.named = "series";
  seed.bone = bone_from_file(seed.folder + "/series");
  writer.add(std::move(seed));
}

void add_vdb(SeedWriter& writer) {
  BoneSettings settings;
  settings.source = BoneSource::phantom;
  settings.voxel_mm = 0.5;
  settings.phantom.shape = PhantomShape::sphere;
  settings.phantom.radius_mm = 4;
  Diagnostics report;
  const FilledVoxmap bone = load_bone(settings, report).copy_voxels();
  writer.add("VDB of reamsim", "bone.vdb", [&](const std::string& path) { write_bone_vdb(path, bone, {}, {}); });
  writer.add("VDB", "foreign.vdb", [&](const std::string& path) {
    write_bone_vdb(path + ".own", bone, {}, {});
    openvdb::io::File in(path + ".own");
    in.open(false);
    const openvdb::GridPtrVec grids = {in.readGrid("density"), in.readGrid("fill")};
    in.close();
    openvdb::io::File(path).write(grids);
    fs::remove(path + ".own");
  });
}

}  // namespace

std::vector<Seed> write_seeds(const std::string& folder) {
  SeedWriter writer(folder);
  add_meshes(writer);
  add_images(writer);
  add_labels(writer);
  for (const bool enhanced : {false, true}) add_dicom(writer, enhanced);
  add_vdb(writer);
  return writer.take();
}

BoneSettings bone_from_file(const std::string& path) {
  BoneSettings settings = settings_for(path, 1);
  settings.ct.closing_mm = 1.5;
  const std::string extension = fs::path(path).extension().string();
  if (std::set<std::string>{".stl", ".ply", ".obj", ".vtp"}.contains(extension)) {
    settings.source = BoneSource::mesh;
    settings.mesh.path = path;
  } else if (extension == ".vdb") {
    settings.source = BoneSource::vdb;
    settings.vdb.path = path;
  } else {
    settings.source = BoneSource::ct;
  }
  return settings;
}

void load(const BoneSettings& bone) {
  Diagnostics report;
  load_bone(bone, report);
}

}  // namespace reamsim::test
