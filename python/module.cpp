#include "python/runtime.hpp"

PYBIND11_MODULE(_carillon, module) {
  carillon::python::set_up(module);
  carillon::python::bind_objects(module);
  carillon::python::bind_sounds(module);
  carillon::python::bind_datasets(module);
  carillon::python::bind_learning(module);
}
