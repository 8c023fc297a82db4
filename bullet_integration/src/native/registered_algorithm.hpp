#pragma once

class btCollisionDispatcher;
struct btCollisionAlgorithmCreateFunc;

namespace softcd::bullet {

/// While it lives, `dispatcher` makes the algorithms for pairs of these types of shapes with `create`. Its destructor
/// restores the former entry, unless the entry has changed again.
class RegisteredAlgorithm {
 public:
  RegisteredAlgorithm(btCollisionDispatcher& dispatcher, int type0, int type1, btCollisionAlgorithmCreateFunc& create);
  ~RegisteredAlgorithm();
  RegisteredAlgorithm(const RegisteredAlgorithm&) = delete;
  RegisteredAlgorithm& operator=(const RegisteredAlgorithm&) = delete;

  /// Returns the former entry.
  btCollisionAlgorithmCreateFunc& original() const { return *original_; }

 private:
  btCollisionAlgorithmCreateFunc*& entry_;  ///< in the dispatcher's table
  btCollisionAlgorithmCreateFunc* create_;
  btCollisionAlgorithmCreateFunc* original_;
};

}  // namespace softcd::bullet
