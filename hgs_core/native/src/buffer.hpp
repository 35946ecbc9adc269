// An array that only grows, so that repeated calls allocate nothing.
#pragma once

#include <algorithm>
#include <cstddef>
#include <new>
#include <type_traits>

namespace hgs {

template <class T>
class Buffer {
  static_assert(std::is_trivially_copyable_v<T>, "contents are left uninitialised");

 public:
  Buffer() = default;
  Buffer(Buffer &&other) noexcept : data_(other.data_), capacity_(other.capacity_) {
    other.data_ = nullptr;
    other.capacity_ = 0;
  }
  Buffer &operator=(Buffer &&) = delete;
  ~Buffer() { release(); }

  // Make room for `size` elements; earlier contents are lost when it has to grow, but for the first `kept`.
  T *reserve(size_t size, size_t kept = 0) {
    if (size > capacity_) {
      const size_t rounded = size + size / 4 + 64;  // a little more, so that slow growth does not reallocate each time
      if (kept == 0) release();
      T *const fresh = static_cast<T *>(::operator new(rounded * sizeof(T), kAlignment));
      std::copy_n(data_, kept, fresh);
      release();
      data_ = fresh;
      capacity_ = rounded;
    }
    return data_;
  }

  T *data() { return data_; }
  const T *data() const { return data_; }
  T &operator[](size_t i) { return data_[i]; }
  const T &operator[](size_t i) const { return data_[i]; }

 private:
  static constexpr std::align_val_t kAlignment{64};

  void release() {
    if (data_ != nullptr) ::operator delete(data_, kAlignment);
    data_ = nullptr;
    capacity_ = 0;
  }

  T *data_ = nullptr;
  size_t capacity_ = 0;
};

}  // namespace hgs
