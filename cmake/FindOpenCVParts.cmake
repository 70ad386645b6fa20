# The few OpenCV modules that vildar uses, found one by one, so that a machine needs only their
# packages (libopencv-core-dev and so on) and not the whole of libopencv-dev.
# Defines opencv::<component> for each component asked for.
find_path(OpenCVParts_INCLUDE_DIR opencv2/core.hpp PATH_SUFFIXES opencv4)
set(_required OpenCVParts_INCLUDE_DIR)
foreach(_part IN LISTS OpenCVParts_FIND_COMPONENTS)
  find_library(OpenCVParts_${_part}_LIBRARY opencv_${_part})
  find_path(OpenCVParts_${_part}_HEADER opencv2/${_part}.hpp PATH_SUFFIXES opencv4)
  if(OpenCVParts_${_part}_LIBRARY AND OpenCVParts_${_part}_HEADER)
    set(OpenCVParts_${_part}_FOUND TRUE)
    if(NOT TARGET opencv::${_part})
      add_library(opencv::${_part} UNKNOWN IMPORTED)
      set_target_properties(opencv::${_part} PROPERTIES
        IMPORTED_LOCATION "${OpenCVParts_${_part}_LIBRARY}"
        INTERFACE_INCLUDE_DIRECTORIES "${OpenCVParts_${_part}_HEADER}")
    endif()
  endif()
endforeach()
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(OpenCVParts REQUIRED_VARS ${_required} HANDLE_COMPONENTS)
