#include "sim/record/vti.h"

#include <zlib.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <vector>

#include "sim/base/error.h"

namespace reamsim {

namespace {

// Debian's VTK would bring Qt and MPI along; the format is an XML header and zlib blocks.
constexpr std::size_t kBlockVoxels = 1 << 18;

std::string number(double value) {
  char digits[32];
  return {digits, std::to_chars(digits, digits + sizeof digits, value).ptr};
}

std::string header(const VoxelGrid& grid) {
  const Vec3 first = grid.center_mm(0, 0, 0);
  std::string extent, origin, spacing;
  for (int i = 0; i < 3; ++i) {
    const char* space = i < 2 ? " " : "";
    extent += "0 " + std::to_string(grid.dims[i] - 1) + space;
    origin += number(first[i]) + space;
    spacing += number(grid.voxel_mm) + space;
  }
  return "<?xml version=\"1.0\"?>\n"
         "<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\" "
         "compressor=\"vtkZLibDataCompressor\">\n"
         "<ImageData WholeExtent=\"" +
         extent + "\" Origin=\"" + origin + "\" Spacing=\"" + spacing +
         "\">\n"
         "<Piece Extent=\"" +
         extent +
         "\">\n<PointData Scalars=\"density_g_cm3\">\n"
         "<DataArray type=\"Float32\" Name=\"density_g_cm3\" format=\"appended\" offset=\"0\"/>\n"
         "</PointData>\n</Piece>\n</ImageData>\n<AppendedData encoding=\"raw\">\n_";
}

std::vector<float> density_block(const Voxmap& voxmap, std::size_t begin, std::size_t end) {
  std::vector<float> out(end - begin, 0.0F);
  for (std::size_t e = begin; e < end; ++e) {
    if (voxmap.grade[e] == 0) continue;
    const double fill = voxmap.fill.get(voxmap.grid.coord(static_cast<std::int64_t>(e))) / double{FillBricks::kWhole};
    out[e - begin] = static_cast<float>(fill * DensityMapping::density_from_grade(voxmap.grade[e]));
  }
  return out;
}

std::vector<unsigned char> deflated(const std::vector<float>& values) {
  const auto bytes = static_cast<uLong>(values.size() * sizeof(float));
  std::vector<unsigned char> out(compressBound(bytes));
  uLongf size = out.size();
  compress2(out.data(), &size, reinterpret_cast<const Bytef*>(values.data()), bytes, Z_BEST_SPEED);
  out.resize(size);
  return out;
}

}  // namespace

void write_vti(const std::string& path, const Voxmap& voxmap) {
  const std::size_t voxels = voxmap.grade.size();
  const std::size_t blocks = (voxels + kBlockVoxels - 1) / kBlockVoxels;
  std::vector<std::uint64_t> sizes{blocks, kBlockVoxels * sizeof(float), voxels % kBlockVoxels * sizeof(float)};
  sizes.resize(3 + blocks);
  std::ofstream out(path, std::ios::binary);
  const auto put = [&](const auto& items) {
    out.write(reinterpret_cast<const char*>(items.data()),
              static_cast<std::streamsize>(items.size() * sizeof items[0]));
  };
  out << header(voxmap.grid);
  const auto table = out.tellp();
  put(sizes);
  for (std::size_t b = 0; b < blocks; ++b) {
    const auto block = deflated(density_block(voxmap, b * kBlockVoxels, std::min(voxels, (b + 1) * kBlockVoxels)));
    sizes[3 + b] = block.size();
    put(block);
  }
  out << "\n</AppendedData>\n</VTKFile>\n";
  out.seekp(table);
  put(sizes);
  out.close();
  if (!out) throw RunError(path + ": cannot be written; is the disk full or the folder read-only?");
}

}  // namespace reamsim
