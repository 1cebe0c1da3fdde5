"""Bodies with closed-form states: levels, wave functions, and the quasiclassical levels beside them."""
