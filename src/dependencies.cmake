# The libraries that noiseloom is built on, found in the same way by its own build and by whoever uses the installed package.
# noiseloom_image_libraries: whether those that only images and spectra need are wanted.

find_package(Threads REQUIRED)
find_package(MPI REQUIRED COMPONENTS CXX)
find_package(fmt REQUIRED)
find_package(PkgConfig REQUIRED)
pkg_check_modules(xxhash REQUIRED IMPORTED_TARGET libxxhash)
pkg_check_modules(highway REQUIRED IMPORTED_TARGET libhwy)
if(noiseloom_image_libraries)
  pkg_check_modules(fftw REQUIRED IMPORTED_TARGET fftw3)
endif()

# The C library of HDF5, any build of 1.10 or later. It is looked for where Debian has the serial one, then by HDF5's own CMake
# package, then by h5cc (-DHDF5_ROOT=... helps); a parallel build serves too, as it is used serially.
if(NOT TARGET noiseloom_hdf5)
  add_library(noiseloom_hdf5 INTERFACE IMPORTED)
  pkg_check_modules(hdf5_serial QUIET IMPORTED_TARGET hdf5-serial)
  if(hdf5_serial_FOUND AND NOT HDF5_ROOT)
    target_link_libraries(noiseloom_hdf5 INTERFACE PkgConfig::hdf5_serial)
  else()
    find_package(HDF5 CONFIG QUIET COMPONENTS C)
    if(TARGET hdf5::hdf5-shared)
      target_link_libraries(noiseloom_hdf5 INTERFACE hdf5::hdf5-shared)
    elseif(TARGET hdf5-shared)
      target_link_libraries(noiseloom_hdf5 INTERFACE hdf5-shared)
    else()
      enable_language(C)  # the module compiles in C
      find_package(HDF5 MODULE REQUIRED COMPONENTS C)
      target_link_libraries(noiseloom_hdf5 INTERFACE ${HDF5_C_LIBRARIES})
      target_include_directories(noiseloom_hdf5 INTERFACE ${HDF5_C_INCLUDE_DIRS})
    endif()
  endif()
endif()
