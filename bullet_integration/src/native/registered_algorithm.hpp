#pragma once

class btCollisionDispatcher;
struct btCollisionAlgorithmCreateFunc;

namespace softcd::bullet {

/// While it lives `dispatcher` makes the algorithms for pairs of these types of shapes with `create`. Afterwards as
/// before, but where somebody has registered something else meanwhile.
class RegisteredAlgorithm {
 public:
  RegisteredAlgorithm(btCollisionDispatcher& dispatcher, int type0, int type1, btCollisionAlgorithmCreateFunc& create);
  ~RegisteredAlgorithm();
  RegisteredAlgorithm(const RegisteredAlgorithm&) = delete;
  RegisteredAlgorithm& operator=(const RegisteredAlgorithm&) = delete;

  /// What stood there before.
  btCollisionAlgorithmCreateFunc& original() const { return *original_; }

 private:
  btCollisionAlgorithmCreateFunc*& entry_;  ///< in the dispatcher's table
  btCollisionAlgorithmCreateFunc* create_;
  btCollisionAlgorithmCreateFunc* original_;
};

}  // namespace softcd::bullet
