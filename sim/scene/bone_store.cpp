// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scene/bone_store.h"

#include <link.h>
#include <openssl/evp.h>
#include <sys/stat.h>
#include <unistd.h>
#include <algorithm>
#include <array>
#include <cstdlib>
#include <memory>
#include <optional>
#include <span>

#include "sim/base/checksum.h"
#include "sim/base/value_file.h"
#include "sim/scenario/parse.h"

namespace reamsim {

namespace {

namespace fs = std::filesystem;

constexpr const char* kEnding = ".bone";

/// A bone with what was said while it was loaded.
struct KeptBone {
  Bone bone;
  Diagnostics report;
};

/// Visits bricks, each after its coordinates.
template <class Bricks>
void visit_bricks(ValueWriter& visit, const Bricks& bricks) {
  visit.put(bricks.stored_bricks());
  bricks.for_each_brick([&](const Vec3i& coord, const auto& brick) {
    visit(coord);
    visit(brick);
  });
}
template <class Bricks>
void visit_bricks(ValueReader& visit, Bricks& bricks) {
  for (auto left = visit.take<std::size_t>(); left > 0; --left) {
    const auto coord = visit.take<Vec3i>();
    if (!bricks.lattice().contains(coord)) throw DamagedValues();
    bricks.put(coord, visit.take<typename Bricks::Brick>());
  }
}

/// Visits all but the bricks, in the order of the file. `voxmap`: that of the bone.
template <class Visit, class Voxels, class Kept>
void visit_values(Visit& visit, Voxels& voxmap, Kept& kept) {
  const auto visit_each = [&visit](auto&... values) { (visit(values), ...); };
  auto& bone = kept.bone;
  visit_each(voxmap.mapping, voxmap.frame, voxmap.layers, bone.glenoid, bone.landmarks, bone.scapula, bone.side,
             bone.segmentation, bone.rim_mm, kept.report);
}

constexpr std::string_view kBoneMagic = "reamsim bone 1\n";

std::string text_of(const KeptBone& kept) {
  ValueWriter writer(kBoneMagic);
  const Voxmap& voxmap = *kept.bone.voxmap;
  writer(voxmap.grid);
  visit_bricks(writer, voxmap.grade);
  visit_bricks(writer, kept.bone.fill);
  visit_values(writer, voxmap, kept);
  return writer.finish();
}

/// Throws DamagedValues.
KeptBone bone_of(std::string_view text) {
  ValueReader reader(values_of(text, kBoneMagic));
  const auto grid = reader.take<VoxelGrid>();
  if ((grid.dims.array() < 0).any()) throw DamagedValues();
  FilledVoxmap voxels(grid);
  visit_bricks(reader, voxels.grade);
  visit_bricks(reader, voxels.fill);
  KeptBone kept;
  visit_values(reader, static_cast<Voxmap&>(voxels), kept);
  kept.bone.set_voxels(std::move(voxels));
  return kept;
}

/// The builds of the program or library that this code is part of, and of the libraries that read and filter scans and
/// meshes: their build ids, which the linker makes of their content.
std::string build_ids() {
  std::string ids;
  const auto add = [](dl_phdr_info* object, std::size_t, void* out) {
    const std::string_view name = object->dlpi_name;
    const auto own = reinterpret_cast<ElfW(Addr)>(&build_ids);
    bool counts = std::ranges::any_of(std::array{"ITK", "itk", "gdcm", "openvdb", "assimp"},
                                      [&](const char* part) { return name.find(part) != name.npos; });
    const std::span parts(object->dlpi_phdr, object->dlpi_phnum);
    for (const ElfW(Phdr) & part : parts) {
      const ElfW(Addr) begin = object->dlpi_addr + part.p_vaddr;
      counts = counts || (part.p_type == PT_LOAD && own >= begin && own < begin + part.p_memsz);
    }
    for (const ElfW(Phdr) & part : parts) {
      if (!counts || part.p_type != PT_NOTE) continue;
      const auto* notes = reinterpret_cast<const char*>(object->dlpi_addr + part.p_vaddr);
      static_cast<std::string*>(out)->append(notes, part.p_memsz);
    }
    return 0;
  };
  dl_iterate_phdr(add, &ids);
  return ids;
}

/// Whether a file, or all of a folder, can be read soon: devices and pipes may have no end.
bool is_quick_to_read(const fs::path& path) {
  constexpr std::uintmax_t kMost = 4'000'000'000, kPerFile = 100'000;  // as long as a file takes to open
  std::error_code error;
  if (!fs::is_directory(path, error)) return fs::is_regular_file(path, error) && fs::file_size(path, error) < kMost;
  std::uintmax_t bytes = 0;
  fs::recursive_directory_iterator at(path, fs::directory_options::skip_permission_denied, error), end;
  for (; !error && at != end && bytes < kMost; at.increment(error))
    if (at->is_regular_file(error)) bytes += kPerFile + at->file_size(error);
  return !error && bytes < kMost;
}

/// What the bone is made from; throws where that cannot be read soon. Its checksum is the key of the cipher.
std::string origin_of(const BoneSettings& settings) {
  Scenario scenario;  // whose other sections are the defaults
  scenario.bone = settings;
  std::string origin = "reamsim " REAMSIM_VERSION "\n" + build_ids() + "\n" + to_yaml(scenario);
  for (const auto& [role, path] : input_files(scenario)) {
    // Results publish the checksum of the file alone, from which this one does not follow.
    if (path.empty()) continue;
    if (!is_quick_to_read(path)) throw RunError("not stored");
    origin += role + " " + sha256_of(path, "reamsim bone\n") + "\n";
  }
  return origin;
}

constexpr int kTagBytes = 16;
using CipherContext = std::unique_ptr<EVP_CIPHER_CTX, decltype(&EVP_CIPHER_CTX_free)>;

/// AES-256-GCM of `text`, whose tag is at its end. A key encrypts one text only: no nonce is needed. nullopt where the
/// text to decrypt is not one that was encrypted with this key.
std::optional<std::string> crypted(const std::string& text, const std::string& key_hex, bool encrypt) {
  unsigned char key[32], nonce[12] = {};
  for (std::size_t i = 0; i < sizeof key; ++i) {
    key[i] = static_cast<unsigned char>(std::stoi(key_hex.substr(2 * i, 2), nullptr, 16));
  }
  const std::size_t size = encrypt ? text.size() : text.size() - std::min<std::size_t>(text.size(), kTagBytes);
  const CipherContext context(EVP_CIPHER_CTX_new(), EVP_CIPHER_CTX_free);
  std::string out(size + kTagBytes, '\0');
  auto* to = reinterpret_cast<unsigned char*>(out.data());
  int done = 0;
  if (EVP_CipherInit_ex(context.get(), EVP_aes_256_gcm(), nullptr, key, nonce, encrypt ? 1 : 0) != 1) return {};
  if (!encrypt) {
    std::string tag = text.substr(size);
    tag.resize(kTagBytes);
    EVP_CIPHER_CTX_ctrl(context.get(), EVP_CTRL_GCM_SET_TAG, kTagBytes, tag.data());
  }
  const auto* from = reinterpret_cast<const unsigned char*>(text.data());
  if (EVP_CipherUpdate(context.get(), to, &done, from, static_cast<int>(size)) != 1) return {};
  if (EVP_CipherFinal_ex(context.get(), to + done, &done) != 1) return {};
  if (encrypt) EVP_CIPHER_CTX_ctrl(context.get(), EVP_CTRL_GCM_GET_TAG, kTagBytes, out.data() + size);
  out.resize(encrypt ? size + kTagBytes : size);
  return out;
}

/// Reads the file of a bone; nullopt where there is none. A damaged one is removed.
std::optional<KeptBone> read_bone(const fs::path& path, const std::string& key) {
  const std::optional<std::string> file = read_whole_file(path.string());
  if (!file) return std::nullopt;
  std::error_code ignored;
  try {
    if (const auto text = crypted(*file, key, false)) {
      KeptBone kept = bone_of(*text);
      fs::last_write_time(path, fs::file_time_type::clock::now(), ignored);  // when it was used
      return kept;
    }
  } catch (const std::bad_alloc&) {
    return std::nullopt;
  } catch (const DamagedValues&) {  // as one that cannot be decrypted
  }
  fs::remove(path, ignored);
  return std::nullopt;
}

/// Writes the whole file or none.
void write_bone(const fs::path& path, const std::string& content) {
  std::error_code ignored;
  fs::create_directories(path.parent_path(), ignored);
  fs::permissions(path.parent_path(), fs::perms::owner_all, ignored);
  std::string name = path.string() + ".XXXXXX";
  const int file = mkstemp(name.data());  // readable by this user alone
  if (file < 0) return;
  std::size_t written = 0;
  for (ssize_t got = 1; written < content.size() && got > 0;
       written += static_cast<std::size_t>(std::max<ssize_t>(0, got)))
    got = write(file, content.data() + written, content.size() - written);
  const bool whole = written == content.size() && close(file) == 0;
  if (!whole || rename(name.c_str(), path.c_str()) != 0) unlink(name.c_str());
}

}  // namespace

fs::path BoneStore::usual_folder(bool even_if_off) {
  const auto value = [](const char* name) {
    const char* text = std::getenv(name);
    return std::string(text == nullptr ? "" : text);
  };
  const std::string cache = value("XDG_CACHE_HOME"), home = value("HOME");
  if ((value("REAMSIM_CACHE") == "off" && !even_if_off) || (cache.empty() && home.empty())) return {};
  return fs::path(cache.empty() ? home + "/.cache" : cache) / "reamsim" / "bones";
}

Bone BoneStore::find_or_load(const BoneSettings& settings, Diagnostics& report,
                             const std::function<Bone(Diagnostics& report)>& load) const {
  if (folder_.empty() || !settings.cache || settings.source == BoneSource::vdb) return load(report);
  std::string key;
  try {
    key = sha256_of_text(origin_of(settings));
  } catch (const std::exception&) {  // load() says which file cannot be read
    return load(report);
  }
  const fs::path path = folder_ / (sha256_of_text(key) + kEnding);
  if (auto kept = read_bone(path, key)) {
    report.append(kept->report);
    return std::move(kept->bone);
  }
  KeptBone kept;
  try {
    kept.bone = load(kept.report);
  } catch (...) {
    report.append(kept.report);
    throw;
  }
  report.append(kept.report);
  if (kept.bone.voxmap->grade.bytes() + kept.bone.fill.bytes() < kMostBytesOfBone) try {
      if (const auto content = crypted(text_of(kept), key, true)) {
        write_bone(path, *content);
        remove_beyond(most_bytes_);
      }
    } catch (const std::bad_alloc&) {  // the run may have enough memory without its copy
    }
  return std::move(kept.bone);
}

std::vector<BoneStore::StoredFile> BoneStore::files() const {
  std::vector<StoredFile> out;
  std::error_code error;
  for (fs::directory_iterator at(folder_, error), end; !error && at != end; at.increment(error)) {
    std::error_code removed;  // by another process
    const StoredFile file{at->last_write_time(removed), at->file_size(removed), at->path()};
    if (!removed && file.path.filename().string().find(kEnding) != std::string::npos) out.push_back(file);
  }
  return out;
}

std::pair<int, std::uintmax_t> BoneStore::size() const {
  std::pair<int, std::uintmax_t> out;
  for (const StoredFile& file : files()) out = {out.first + 1, out.second + file.bytes};
  return out;
}

void BoneStore::remove_beyond(std::uintmax_t most_bytes) const {
  std::vector<StoredFile> all = files();
  std::ranges::sort(all, std::greater<>(), &StoredFile::used);
  std::uintmax_t bytes = 0;
  for (const StoredFile& file : all) {
    std::error_code ignored;
    bytes += file.bytes;
    if (bytes > most_bytes) fs::remove(file.path, ignored);
  }
}

}  // namespace reamsim
