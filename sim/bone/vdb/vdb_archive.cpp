// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <fmt/ranges.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <future>
#include <iterator>
#include <memory>
#include <optional>

#include "sim/base/checksum.h"
#include "sim/base/error.h"
#include "sim/base/file.h"
#include "sim/base/process.h"
#include "sim/bone/vdb/grids.h"
#include "sim/isolation/read_in_child.h"

namespace reamsim {

namespace {

namespace fs = std::filesystem;

/// Metadata of a file with a trailer. Names are written in alphabetical order, so it is near the beginning.
constexpr const char* kTrailerKey = "_reamsim_trailer";
constexpr const char* kTrailerValue = "CRC-32 of all bytes before it";
constexpr std::size_t kKeySearchBytes = 1 << 16;
constexpr std::size_t kTrailerBytes = 23;
constexpr std::string_view kMagic("\x20\x42\x44\x56\0\0\0\0", 8);  // the first eight bytes of any VDB file

/// Writes grid after grid to a checked stream. OpenVDB's own File needs all grids at once, and ignores a full disk.
class StreamArchive : public openvdb::io::Archive {
 public:
  void write_to(std::ostream& out, const std::vector<GridMaker>& grids, const openvdb::MetaMap& metadata) const {
    writeHeader(out, /*seekable=*/true);
    metadata.writeMeta(out);
    const auto count = static_cast<openvdb::Int32>(grids.size());
    out.write(reinterpret_cast<const char*>(&count), sizeof count);
    std::future<openvdb::GridBase::Ptr> next;
    for (std::size_t i = 0; i < grids.size(); ++i) {
      openvdb::GridBase::Ptr grid = i == 0 ? grids[i]() : next.get();
      if (i + 1 < grids.size()) next = std::async(std::launch::async, grids[i + 1]);
      grid->addStatsMetadata();
      grid->insertMeta(openvdb::GridBase::META_FILE_COMPRESSION,
                       openvdb::StringMetadata(openvdb::io::compressionToString(compression())));
      openvdb::io::GridDescriptor descriptor(grid->getName(), grid->type(), grid->saveFloatAsHalf());
      writeGrid(descriptor, grid, out, /*seekable=*/true);
      grid.reset();
      return_free_memory();
    }
  }
};

/// CRC-32 of the first `bytes` bytes; nullopt if they cannot be read.
std::optional<std::uint32_t> checksum(std::istream& in, std::uintmax_t bytes) {
  std::uint32_t sum = 0;
  std::vector<char> block(1 << 20);
  while (bytes > 0) {
    block.resize(std::min<std::uintmax_t>(bytes, block.size()));
    if (!in.read(block.data(), std::ssize(block))) return std::nullopt;
    sum = crc_of({block.data(), block.size()}, sum);
    bytes -= block.size();
  }
  return sum;
}

std::string trailer(std::uint32_t sum) {
  return fmt::format("REAMSIM-CRC32 {:08x}\n", sum);
}

/// Where OpenVDB writes a random identifier, 36 characters, with which it recognizes a file that has changed.
constexpr std::streamoff kUuidPlace = 21;
constexpr std::size_t kUuidBytes = 36;

bool overwrite(const std::string& path, std::streamoff place, const std::string& text) {
  std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
  file.seekp(place) << text;
  file.close();
  return file.good();
}

/// Replaces the random identifier by one of the contents, and appends the trailer.
bool finish_file(const std::string& path) {
  std::error_code error;
  const std::uintmax_t bytes = fs::file_size(path, error);
  if (error || !overwrite(path, kUuidPlace, std::string(kUuidBytes, '0'))) return false;
  for (const bool identified : {false, true}) {
    std::ifstream in(path, std::ios::binary);
    const std::optional<std::uint32_t> sum = checksum(in, bytes);
    if (!sum) return false;
    // RFC 9562, version 8.
    const std::string uuid = fmt::format("{:08x}-0000-8000-8000-{:012x}", *sum, bytes & 0xFFFFFFFFFFFFULL);
    const bool written = identified ? overwrite(path, static_cast<std::streamoff>(bytes), trailer(*sum))
                                    : overwrite(path, kUuidPlace, uuid);
    if (!written) return false;
  }
  return true;
}

/// Throws what a maker throws.
bool write_grids(const std::string& path, const std::vector<GridMaker>& grids, const openvdb::MetaMap& metadata) {
  std::ofstream out(path, std::ios::binary | std::ios::trunc);
  if (!out) return false;
  try {
    StreamArchive().write_to(out, grids, metadata);
  } catch (const openvdb::IoError&) {
    return false;
  }
  out.close();
  return out.good();
}

/// OpenVDB only warns, and misreads the file.
void check_version(const std::string& path, const std::string& start) {
  std::uint32_t version = 0;
  if (start.size() >= kMagic.size() + sizeof version) {
    std::memcpy(&version, start.data() + kMagic.size(), sizeof version);
  }
  constexpr std::uint32_t kOldest = openvdb::OPENVDB_FILE_VERSION_ROOTNODE_MAP;
  constexpr std::uint32_t kNewest = openvdb::OPENVDB_FILE_VERSION;
  if (version >= kOldest && version <= kNewest) return;
  refuse_file(path, "a VDB of file version " + std::to_string(version),
              "expected " + std::to_string(kOldest) + " to " + std::to_string(kNewest) + ", or the file is damaged");
}

/// Throws InputError: unreadable, no VDB, a wrong checksum. Returns whether there is one: other programs write none.
bool check_bytes(const std::string& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) refuse_file(path, "no such file", "expected a VDB file");
  if (!fs::is_regular_file(status)) refuse_file(path, "not a file", "expected a VDB file");
  const std::uintmax_t size = fs::file_size(path, error);
  std::ifstream in(path, std::ios::binary);
  if (error || !in) refuse_file(path, "cannot be read", "expected a readable VDB file");
  if (size == 0) refuse_file(path, "an empty file", "expected a VDB file");
  const std::string start = read_file_start(path, kKeySearchBytes);
  if (!start.starts_with(kMagic)) refuse_file(path, "not a VDB file", "expected an OpenVDB file, as reamsim writes it");
  check_version(path, start);
  if (start.find(kTrailerKey) == std::string::npos) return false;
  const std::string damaged = "a truncated or damaged VDB file (its checksum does not match)";
  if (size < kTrailerBytes) refuse_file(path, damaged, "expected a complete file");
  const std::optional<std::uint32_t> sum = checksum(in, size - kTrailerBytes);
  std::string found(kTrailerBytes, '\0');
  in.read(found.data(), static_cast<std::streamsize>(found.size()));
  if (!in || !sum || found != trailer(*sum)) refuse_file(path, damaged, "expected a complete file");
  return true;
}

/// A grid of a file, in the child.
openvdb::FloatGrid::Ptr read_grid(openvdb::io::File& file, const std::string& path, const std::string& name) {
  openvdb::GridBase::Ptr any;
  try {
    any = file.readGrid(name);
  } catch (const openvdb::Exception&) {
    refuse_file(path, "a truncated or damaged grid \"" + name + "\"", "expected a complete VDB file");
  }
  const auto grid = std::dynamic_pointer_cast<openvdb::FloatGrid>(any);
  if (!grid) {
    refuse_file(path, "a grid \"" + name + "\" of type " + (any ? any->valueType() : "none"), "expected a FloatGrid");
  }
  return grid;
}

/// The wanted grids that the file has; none without the first, of which the others are part.
std::vector<std::string> grids_to_read(const std::vector<std::string>& names, const std::vector<std::string>& wanted) {
  std::vector<std::string> out;
  std::ranges::copy_if(wanted, std::back_inserter(out), [&](const std::string& name) {
    return std::ranges::count(names, name) > 0 && std::ranges::count(names, wanted.front()) > 0;
  });
  return out;
}

/// The names of all grids, and grids_to_read(); in the child.
void put_grids(ResultWriter& out, const std::string& path, const std::vector<std::string>& wanted) {
  openvdb::initialize();
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  try {
    openvdb::io::File file(path);
    file.open(/*delayLoad=*/false);
    std::vector<std::string> names;
    for (auto name = file.beginName(); name != file.endName(); ++name) names.push_back(*name);
    out.put(names);
    for (const std::string& name : grids_to_read(names, wanted)) put_grid(out, *read_grid(file, path, name));
  } catch (const openvdb::Exception&) {
    refuse_file(path, "a truncated or damaged VDB file", "expected a complete file");
  }
}

}  // namespace

bool is_vdb_of_reamsim(const std::string& path) {
  const std::string start = read_file_start(path, kKeySearchBytes);
  return start.starts_with(kMagic) && start.find(kTrailerKey) != std::string::npos;
}

void write_vdb_file(const std::string& path, const std::vector<GridMaker>& grids, const openvdb::MetaMap& metadata) {
  openvdb::MetaMap marked(metadata);
  marked.insertMeta(kTrailerKey, openvdb::StringMetadata(kTrailerValue));
  const auto remove_partial = [](const std::string* partial) {
    std::error_code ignored;
    fs::remove(*partial, ignored);
  };
  const std::string partial = path + ".tmp";
  const std::unique_ptr<const std::string, decltype(remove_partial)> guard(&partial, remove_partial);
  std::error_code error;
  if (!write_grids(partial, grids, marked) || !finish_file(partial)) fail_to_write(path);
  fs::rename(partial, path, error);
  if (error) fail_to_write(path);
}

VdbGrids read_vdb_file(const std::string& path, const std::vector<std::string>& wanted, VdbOrigin origin) {
  constexpr std::uint64_t kMemoryPerFileByte = 200;  // about the compression of constant regions
  openvdb::initialize();
  if (!check_bytes(path) && origin == VdbOrigin::kReamsim) {
    refuse_file(path, "a truncated or damaged VDB file (its checksum is missing)",
                "expected a complete file of reamsim's");
  }
  const std::uint64_t bytes = bytes_of_file(path);
  ReadLimits limits = ReadLimits().with(bytes, kMemoryPerFileByte * bytes);
  limits.result_bytes = limits.memory_bytes;
  ResultReader result = read_in_child<put_grids>({path, ""}, limits, path, wanted);
  const std::vector<std::string> names = result.texts();
  VdbGrids out{.names = names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", ")), .grids = {}};
  for (const std::string& name : grids_to_read(names, wanted)) out.grids[name] = take_grid(result);
  return out;
}

openvdb::FloatGrid::Ptr read_vdb_grid(const std::string& path, const std::string& name, VdbOrigin origin) {
  const VdbGrids file = read_vdb_file(path, {name}, origin);
  if (file.grids.empty())
    refuse_file(path, "no grid \"" + name + "\" (found: " + file.names + ")", "expected a FloatGrid");
  return file.grids.begin()->second;
}

}  // namespace reamsim
