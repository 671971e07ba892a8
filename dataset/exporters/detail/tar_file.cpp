#include "dataset/exporters/detail/tar_file.hpp"

#include <archive.h>
#include <archive_entry.h>
#include <fmt/format.h>
#include <locale.h>

#include "core/error.hpp"
#include "core/handle.hpp"

namespace carillon::dataset::exporters {

namespace {

void free_archive(archive** file) {
  archive_write_free(*file);
}
void free_entry(archive_entry** entry) {
  archive_entry_free(*entry);
}

void free_locale(locale_t* locale) {
  freelocale(*locale);
}

/// Names are UTF-8 while this lives, for the thread. libarchive converts them by the locale, and
/// the program's is "C": some versions crash over a name that this does not hold.
class Utf8Names {
 public:
  Utf8Names() {
    if (locale_.get() == locale_t{}) {
      throw core::FileError("the system has no locale C.UTF-8, which tar files need for names");
    }
    before_ = uselocale(locale_.get());
  }
  ~Utf8Names() { uselocale(before_); }
  Utf8Names(const Utf8Names&) = delete;
  Utf8Names& operator=(const Utf8Names&) = delete;

 private:
  core::Handle<locale_t, free_locale> locale_{newlocale(LC_CTYPE_MASK, "C.UTF-8", locale_t{})};
  locale_t before_{};
};

}  // namespace

struct TarFile::State {
  std::string path;
  core::Handle<archive*, free_archive, nullptr> file;
  core::Handle<archive_entry*, free_entry, nullptr> entry;

  void check(int result) const {
    if (result == ARCHIVE_OK) return;
    throw core::FileError(
        fmt::format("{}: cannot be written: {}", path, archive_error_string(file.get())));
  }
};

TarFile::TarFile(const std::filesystem::path& path)
    : state_(
          std::make_unique<State>(State{path.string(), decltype(State::file)(archive_write_new()),
                                        decltype(State::entry)(archive_entry_new())})) {
  archive* file = state_->file.get();
  state_->check(archive_write_set_format_pax_restricted(file));
  state_->check(archive_write_open_filename(file, path.c_str()));
}

TarFile::~TarFile() = default;

void TarFile::add(const std::string& name, std::string_view bytes) {
  const Utf8Names utf8;
  archive* file = state_->file.get();
  archive_entry* entry = state_->entry.get();
  archive_entry_clear(entry);
  archive_entry_set_pathname_utf8(entry, name.c_str());
  archive_entry_set_size(entry, static_cast<la_int64_t>(bytes.size()));
  archive_entry_set_filetype(entry, AE_IFREG);
  archive_entry_set_perm(entry, 0644);
  archive_entry_set_mtime(entry, 0, 0);
  state_->check(archive_write_header(file, entry));
  const la_ssize_t written = archive_write_data(file, bytes.data(), bytes.size());
  if (written != static_cast<la_ssize_t>(bytes.size())) state_->check(ARCHIVE_FATAL);
}

void TarFile::finish() {
  state_->check(archive_write_close(state_->file.get()));
}

}  // namespace carillon::dataset::exporters
