// The format of a checkpoint: numbers as the processor has them, each text and list after its length, a CRC-32 at the
// end.
#include <zlib.h>

#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <type_traits>

#include "sim/base/file.h"
#include "sim/run/checkpoint.h"

namespace reamsim {

namespace {

constexpr std::string_view kMagic = "reamsim checkpoint 4\n";

/// A damaged file.
struct Damaged : std::runtime_error {
  Damaged() : std::runtime_error("damaged") {}
};

std::uint32_t crc_of(std::string_view bytes) {
  return static_cast<std::uint32_t>(crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

/// Appends values to the text of a file.
class Writer {
 public:
  template <class T>
  void operator()(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    text.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  void operator()(const std::string& value) {
    (*this)(value.size());
    text += value;
  }
  void operator()(const Vec3i& v) {
    for (const int i : v) (*this)(i);
  }
  void operator()(const std::optional<Vec3>& v) {
    (*this)(v.has_value());
    if (!v) return;
    for (const double d : *v) (*this)(d);
  }
  template <class First, class Second>
  void operator()(const std::pair<First, Second>& pair) {
    (*this)(pair.first);
    (*this)(pair.second);
  }
  template <class T>
  void operator()(const std::vector<T>& list) {
    (*this)(list.size());
    for (const T& item : list) (*this)(item);
  }
  void operator()(const InputSum& input) {
    for (const std::string* part : {&input.role, &input.path, &input.sha256}) (*this)(*part);
  }

  std::string text{kMagic};
};

/// Reads them again, in the same order.
class Reader {
 public:
  explicit Reader(std::string_view rest) : rest_(rest) {}

  template <class T>
  void operator()(T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    std::memcpy(&value, take(sizeof value).data(), sizeof value);
  }
  void operator()(bool& value) {
    std::uint8_t byte = 0;
    (*this)(byte);
    if (byte > 1) throw Damaged();
    value = byte == 1;
  }
  void operator()(std::string& value) { value = take(length()); }
  void operator()(Vec3i& v) {
    for (int& i : v) (*this)(i);
  }
  void operator()(std::optional<Vec3>& v) {
    bool has = false;
    (*this)(has);
    if (!has) return;
    v.emplace();
    for (double& d : *v) (*this)(d);
  }
  template <class First, class Second>
  void operator()(std::pair<First, Second>& pair) {
    (*this)(pair.first);
    (*this)(pair.second);
  }
  template <class T>
  void operator()(std::vector<T>& list) {
    list.resize(length());
    for (T& item : list) (*this)(item);
  }
  void operator()(InputSum& input) {
    for (std::string* part : {&input.role, &input.path, &input.sha256}) (*this)(*part);
  }

 private:
  std::string_view take(std::size_t bytes) {
    if (bytes > rest_.size()) throw Damaged();
    const std::string_view out = rest_.substr(0, bytes);
    rest_.remove_prefix(bytes);
    return out;
  }
  /// Of a text or a list, each of whose items has a byte or more.
  std::size_t length() {
    std::size_t out = 0;
    (*this)(out);
    if (out > rest_.size()) throw Damaged();
    return out;
  }

  std::string_view rest_;
};

/// Calls visit() for every value of a checkpoint, in the order of the file.
template <class Visit, class State>
void visit_values(Visit& visit, State& c) {
  visit(c.identity.program);
  visit(c.identity.device);
  visit(c.identity.scenario);
  visit(c.identity.inputs);
  visit(c.simulation.frame);
  visit(c.simulation.ledger.work_mj);
  visit(c.simulation.ledger.floor_mj);
  visit(c.simulation.ledger.cut_mj);
  visit(c.simulation.ledger.first_contact_mm);
  visit(c.simulation.touched);
  visit(c.simulation.warned_of_no_spin);
  visit(c.simulation.hand);
  visit(c.simulation.springs);
  visit(c.logs.forces_bytes);
  visit(c.logs.timings_bytes);
  visit(c.logs.basis_bytes);
  visit(c.warnings);
  visit(c.removed);
  visit(c.fill);
  visit(c.changed);
}

std::optional<Checkpoint> read_checkpoint(const std::string& path) {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error) return std::nullopt;
  const std::string text = read_file_start(path, size);
  constexpr std::size_t kSum = sizeof(std::uint32_t);
  if (!text.starts_with(kMagic) || text.size() < kMagic.size() + kSum) return std::nullopt;
  const std::string_view body(text.data(), text.size() - kSum);
  std::uint32_t sum = 0;
  std::memcpy(&sum, body.data() + body.size(), kSum);
  if (sum != crc_of(body)) return std::nullopt;
  try {
    Reader reader(body.substr(kMagic.size()));
    Checkpoint out;
    visit_values(reader, out);
    return out;
  } catch (const Damaged&) {
    return std::nullopt;
  }
}

}  // namespace

std::string CheckpointFiles::path(int number) const {
  return dir_ + "/checkpoint-" + std::to_string(number) + ".bin";
}

std::optional<Checkpoint> CheckpointFiles::read() {
  std::optional<Checkpoint> first = read_checkpoint(path(0)), second = read_checkpoint(path(1));
  const bool take_first = first && (!second || first->simulation.frame >= second->simulation.frame);
  next_ = take_first ? 1 : 0;
  return take_first ? std::move(first) : std::move(second);
}

std::size_t CheckpointFiles::write(const Checkpoint& checkpoint) {
  Writer writer;
  visit_values(writer, checkpoint);
  writer(crc_of(writer.text));
  replace_file(path(next_), writer.text);
  next_ = 1 - next_;
  return writer.text.size();
}

void CheckpointFiles::remove(Report& report) const {
  for (const int number : {0, 1}) {
    std::error_code error;
    std::filesystem::remove(path(number), error);
    if (error) report.warn(path(number) + ": cannot be removed (" + error.message() + "); the results do not need it");
  }
}

}  // namespace reamsim
