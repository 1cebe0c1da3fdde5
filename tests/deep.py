"""Tests that run in the deep tier alone, beside those marked slow: how many cases of each the fast tier keeps.

They take the longest: a case or two of each shows a fault of the code that it tests, all of them one of its corners.
"""

DEEP = {
    "test_accuracy": {
        "test_rounding_next_to_a_separatrix": 1,
        "test_rounding_of_chaotic_orbits": 1,
        "test_errors_of_states_cover_the_truth": 3,
        "test_rounding_in_a_double_well": 1,
        "test_rounding_of_regular_orbits": 1,
        "test_crossings_next_to_a_separatrix": 1,
        "test_an_answer_with_an_error_costs_few_plain_runs": 1,
    },
    "test_affine_bodies": {
        "test_h_is_the_legendre_transform_of_the_kinetic_energy": 1,
        "test_geodesics_are_one_parameter_groups": 1,
        "test_the_affine_spin_is_conserved": 1,
    },
    "test_architecture": {
        "test_public_names_are_there_however_they_are_asked_for": 0,
        "test_what_needs_a_package_that_is_missing_says_which_extra": 1,
    },
    "test_auto": {
        "test_the_default_follows_the_accuracy": 1,
        "test_a_steep_wall_gets_no_fixed_step": 0,
        "test_smooth_motion_gets_a_fixed_step": 0,
        "test_orbits_that_escape_have_no_say": 0,
    },
    "test_chaos": {
        "test_spectra_sum_to_zero_and_pair": 0,
        "test_an_indicator_says_the_same_alone_and_in_any_company": 0,
        "test_every_indicator_knows_the_orbits_of_the_literature": 0,
        "test_zero_one_calls_no_chaotic_orbit_regular": 0,
        "test_integrable_models_have_no_chaotic_orbit": 1,
        "test_isochronous_orbits_have_constant_vectors": 0,
        "test_vectors_that_a_shear_tears_apart_at_once_are_no_evidence_of_chaos": 0,
        "test_schemes_that_keep_something_from_step_to_step_know_no_company": 2,
        "test_vectors_in_directions_at_rest_are_stable": 0,
        "test_orbits_that_meet_steep_forces_late_get_shorter_steps": 0,
        "test_units_change_nothing": 1,
    },
    "test_cli": {
        "test_ctrl_c_keeps_finished_orbits": 0,
        "test_wrong_input_is_one_clear_line": 10,
        "test_systems_of_a_formula": 0,
        "test_bodies_of_a_formula": 0,
    },
    "test_cli_faults": {
        "test_closed_streams_are_no_error": 1,
        "test_a_reader_that_leaves_is_no_error": 1,
        "test_a_full_disk_behind_the_standard_output_is_one_line": 1,
    },
    "test_cli_flows": {
        "test_jobs_carry_them": 2,
    },
    "test_cli_jobs": {
        "test_a_written_job_gives_the_numbers_of_the_command": 0,
        "test_a_store_of_another_processor": 0,
        "test_a_stopped_job_is_resumed_by_the_command_that_is_printed": 0,
        "test_figures_of_spectra": 1,
    },
    "test_cli_momenta": {
        "test_a_section_of_random_starts": 1,
    },
    "test_cli_stops": {
        "test_a_signal_while_python_loads_the_package_is_one_line": 1,
        "test_signals_in_a_row_are_one": 0,
        "test_a_signal_when_all_is_done_changes_nothing": 2,
    },
    "test_closing_errors": {
        "test_errors_cover_closed_forms_whatever_the_multiplier": 1,
        "test_lyapunov_orbits_that_pass_the_moon_closely_have_the_period_of_a_symmetric_shooting": 0,
    },
    "test_contracts": {
        "test_a_new_term_is_one_value": 1,
        "test_a_kind_of_ones_own_runs_by_its_terms": 0,
        "test_a_driven_frame_has_periodic_orbits_and_friction_none": 0,
    },
    "test_cycles": {
        "test_families_of_hills_problem": 0,
    },
    "test_docs": {
        "test_printed_commands_run": 10,
    },
    "test_doctor": {
        "test_help_in_no_columns": 1,
    },
    "test_driven": {
        "test_orbits_against_taylor_series": 1,
        "test_nothing_depends_on_units": 0,
        "test_doubling_of_a_fixed_point_at_rest_is_where_mathieus_equation_has_it": 0,
        "test_mathieu_exponents_agree_with_its_borders_and_with_mpmath": 0,
    },
    "test_elementary": {
        "test_functions_of_one_number_are_right_to_a_unit_in_the_last_place": 2,
    },
    "test_energy_surfaces": {
        "test_both_ways_to_draw_a_surface_agree": 0,
        "test_the_first_points_do_not_depend_on_how_many": 1,
        "test_a_return_keeps_the_measure_of_a_section": 1,
        "test_a_separable_h_told_with_momenta_has_todays_launch_sets": 1,
        "test_the_measure_does_not_know_coordinates": 0,
    },
    "test_engine": {
        "test_first_crossings_are_those_of_poincare_map": 0,
    },
    "test_flow": {
        "test_linear_systems_are_matrix_exponentials": 1,
        "test_exponents_of_linear_systems_are_real_parts": 1,
    },
    "test_formula": {
        "test_energy_and_force_are_those_of_the_formula": 2,
        "test_divided_differences_are_exact_up_to_the_axis": 1,
        "test_orbits_through_beta_zero": 0,
        "test_a_damaged_text_is_written_anew": 0,
    },
    "test_frequency": {
        "test_errors_cover_beside_resonances": 1,
        "test_the_naive_truth_is_the_turning_of_the_planes": 1,
        "test_random_orbits": 1,
    },
    "test_friction": {
        "test_the_sum_of_the_spectrum_is_the_friction": 0,
        "test_crossings_of_a_damped_oscillator": 0,
    },
    "test_fundamental": {
        "test_lines_too_close_to_tell_are_undecided_and_their_errors_know": 0,
        "test_regular_orbits_have_the_lattice_of_their_torus": 0,
        "test_all_frequencies_of_a_linear_chain": 1,
        "test_orbits_of_integrable_systems_are_hardly_ever_irregular_in_short_times": 0,
    },
    "test_fused": {
        "test_a_processor_without_the_instruction_multiplies_and_adds": 0,
    },
    "test_geodesics": {
        "test_orbits_around_a_hole_have_the_frequencies_of_minos_time": 0,
        "test_orbits_in_coordinate_time_have_frequencies_over_gamma": 0,
    },
    "test_grid": {
        "test_units_change_nothing": 1,
    },
    "test_integrate": {
        "test_orbits_that_are_gone_in_finite_time_leave_others_alone": 1,
        "test_lanes_that_fill_up_a_vector_touch_nothing": 2,
    },
    "test_interruption": {
        "test_ctrl_c_while_modules_are_loaded": 1,
    },
    "test_jit_cache": {
        "test_indicators_and_observers_of_ones_own_are_compiled_once_for_each_content": 0,
        "test_an_edited_model_gives_new_numbers": 0,
    },
    "test_job_places": {
        "test_a_store_that_is_moved_while_it_is_written": 1,
    },
    "test_job_store": {
        "test_facts_that_are_missing": 2,
        "test_a_log_of_garbage": 4,
    },
    "test_jobs": {
        "test_a_pool_of_processes": 0,
        "test_workers_that_die": 0,
        "test_a_store_has_the_bits_of_a_run_in_memory": 1,
        "test_a_full_disk": 2,
        "test_a_worker_that_fails": 1,
        "test_a_pool_of_threads": 1,
        "test_a_store_that_another_process_makes_meanwhile_is_gone_on_with": 1,
    },
    "test_kills": {
        "test_whatever_moment_a_command_is_killed_at": 3,
        "test_results_that_are_computed_are_written_whatever_comes": 0,
        "test_ctrl_c_at_any_moment": 2,
    },
    "test_launch_sets": {
        "test_wells_without_end_ask_for_ranges": 1,
        "test_rings_and_wells_far_apart_have_an_end": 0,
        "test_all_wells_share_the_volume_of_an_energy_surface": 1,
        "test_jobs_have_the_same_points_in_any_units": 1,
        "test_points_of_a_section_are_uniform_in_the_ball_of_an_oscillator": 1,
        "test_the_first_points_do_not_depend_on_how_many_are_drawn": 0,
        "test_points_of_an_energy_surface_are_uniform_on_the_sphere_of_an_oscillator": 1,
        "test_points_of_henon_heiles_fill_the_triangle_and_nothing_beyond": 1,
        "test_sections_of_periodic_potentials_ask_for_ranges": 0,
        "test_few_of_the_points_tried_are_enough": 0,
    },
    "test_level_table": {
        "test_levels_without_a_torus_have_a_status_and_no_energy": 0,
        "test_wave_functions_follow_their_levels": 1,
    },
    "test_maps": {
        "test_coupled_planes_of_a_map_have_both_tunes_in_both_windows": 0,
        "test_an_orbit_ends_with_the_same_iterate_in_all_analyses": 0,
        "test_errors_of_doublings_hold": 0,
        "test_lines_of_maps_have_the_amplitudes_and_phases_of_conjugated_rotations": 0,
        "test_starts_are_not_touched": 1,
        "test_maps_of_an_angle_and_a_plane_have_the_tunes_of_both": 0,
        "test_maps_that_are_real_only_far_away": 0,
        "test_a_linear_map_has_its_eigenvalues_for_exponents": 0,
        "test_texts_are_the_named_maps": 2,
        "test_tangent_maps_are_derivatives_and_symplectic": 2,
        "test_windows_at_both_ends_give_tunes_and_diffusion_of_those_who_survive": 0,
        "test_a_plane_that_shows_a_harmonic_of_the_other_has_its_own_tune": 0,
    },
    "test_maps_engine": {
        "test_typed_maps_are_the_packages": 0,
        "test_readings_are_the_packages": 0,
        "test_orbits_that_leave_keep_what_is_known": 0,
    },
    "test_nonseparable": {
        "test_a_uniform_field_written_out_is_the_exact_turn": 0,
        "test_a_rotating_frame_written_out_is_the_exact_turn": 0,
        "test_orbits_are_those_of_the_equations_of_lagrange_within_their_errors": 1,
        "test_sections_at_an_angle_are_meant_up_to_whole_turns": 1,
        "test_a_rotor_coupled_to_nothing_turns_as_it_does": 0,
        "test_a_separable_hamiltonian_written_with_momenta_has_the_bits_of_today": 0,
        "test_errors_of_short_runs_cover_the_truth_by_foci": 0,
        "test_errors_of_short_runs_cover_the_truth": 3,
    },
    "test_nystrom": {
        "test_an_orbit_has_its_bits_in_any_company": 1,
    },
    "test_packs": {
        "test_ones_own_code_comes_before_a_pack_and_what_a_pack_lacks_is_compiled": 0,
        "test_a_pack_of_other_sources_is_not_used": 0,
        "test_a_pack_has_the_bits_of_code_compiled_here": 0,
    },
    "test_page": {
        "test_points_are_sharp_however_deep_the_zoom": 1,
        "test_the_picture_has_axes_and_points": 1,
        "test_where_all_orbits_escape_the_page_says_from_which_energy": 0,
    },
    "test_periodic": {
        "test_units_origin_and_zero_of_the_potential_change_nothing": 0,
        "test_longer_orbits_come_in_pairs": 0,
        "test_schemes_agree": 2,
        "test_same_orbits_are_one_wherever_they_start": 0,
        "test_branches_are_the_same_in_any_units": 1,
    },
    "test_plot": {
        "test_edge_is_where_the_energy_grid_ends": 1,
    },
    "test_plot_limits": {
        "test_options_of_figures_are_taken_or_refused": 20,
    },
    "test_poincare": {
        "test_ctrl_c_stops_a_map_and_hands_over_what_there_is": 0,
        "test_two_crossings_inside_a_step_are_found": 1,
        "test_crossings_are_those_of_scipy": 5,
    },
    "test_processes": {
        "test_a_fork_after_use_computes_the_same": 1,
        "test_the_interpreter_ends_while_daemon_threads_compute": 1,
    },
    "test_progress": {
        "test_a_fit_of_a_torus_tells_its_passes": 0,
    },
    "test_quantum_few": {
        "test_bells_that_do_not_separate": 1,
        "test_bells_of_rho": 1,
        "test_bells_of_alpha_and_of_beta": 6,
    },
    "test_quantum_husimi": {
        "test_width_is_that_of_coherent_packets": 1,
    },
    "test_quantum_listing": {
        "test_bodies_that_do_not_separate": 0,
    },
    "test_quantum_narrow": {
        "test_isolated_bumps": 0,
    },
    "test_quantum_nonseparable": {
        "test_errors_where_convergence_is_algebraic": 0,
        "test_neo_hookean_in_a_plain_basis": 2,
        "test_separable_bodies_as_if_they_were_not": 2,
        "test_weak_attraction_to_the_origin": 1,
    },
    "test_quantum_packets": {
        "test_bodies_that_do_not_separate_take_the_same_way": 0,
        "test_number_packets_are_where_their_angles_say": 1,
        "test_time_scales_agree_with_frequencies_to_order_hbar_squared": 2,
    },
    "test_quantum_statistics": {
        "test_harmonic_count_in_closed_form": 1,
        "test_count_has_no_drift_on_exact_levels": 1,
        "test_leading_term_against_cells": 1,
    },
    "test_quantum_wells": {
        "test_refusals_name_their_reason": 1,
        "test_rings_and_spots_in_the_plane": 1,
    },
    "test_recipe": {
        "test_a_file_is_enough_to_run_again": 2,
    },
    "test_rerun": {
        "test_a_rerun_that_is_stopped_goes_on": 1,
    },
    "test_results": {
        "test_a_spectrum_keeps_the_levels_of_the_last_basis": 1,
    },
    "test_rotating": {
        "test_the_tangent_map_of_a_linear_system_is_an_exponential": 0,
        "test_a_halo_orbit_of_the_catalogue_closes": 0,
        "test_a_turning_frame_shows_the_motion_of_a_frame_at_rest": 1,
        "test_a_magnetic_field_turns_charges_by_the_force_of_lorentz": 1,
        "test_free_motion_is_exact_whatever_the_step": 1,
        "test_a_block_has_the_bits_of_its_text": 2,
        "test_tangent_maps_are_symplectic": 1,
        "test_frequencies_of_turning_springs_are_eigenvalues": 0,
        "test_hills_satellites_lose_their_stability_where_henon_found_it": 0,
        "test_splittings_keep_their_order": 6,
        "test_the_rounding_of_many_turns_is_part_of_the_error": 0,
    },
    "test_scan": {
        "test_integrable_bodies_have_none": 0,
    },
    "test_separable": {
        "test_constants_are_conserved_to_rounding": 5,
    },
    "test_starts": {
        "test_states_from_special_starts_are_within_their_errors": 0,
        "test_no_orbit_within_its_accuracy_drifts_and_errors_cover_at_any_accuracy": 1,
        "test_all_analyses_take_the_centre_of_a_quartic_potential": 0,
    },
    "test_systems": {
        "test_no_body_passes_a_pole_of_its_potential": 1,
        "test_no_orbit_passes_through_the_pole_of_its_chart": 0,
        "test_no_orbit_passes_a_wall_that_its_steps_do_not_see": 1,
        "test_a_pole_whose_residue_is_zero_is_passed": 0,
        "test_both_charts_of_a_top_are_the_same_top": 0,
        "test_kovalevskayas_top_has_no_chaotic_orbit_and_its_neighbour_has": 0,
        "test_eulers_top_is_that_of_jacobi": 0,
    },
    "test_tangent": {
        "test_every_model_is_symplectic_and_follows_the_variational_equations": 1,
        "test_tangent_maps_of_splittings_are_symplectic": 2,
        "test_the_orbit_is_that_of_integrate_to_the_bit": 1,
        "test_vectors_are_the_derivative_of_the_map": 14,
    },
    "test_threads": {
        "test_a_task_needs_no_thread_that_is_busy": 0,
        "test_threads_hold_what_they_write_to": 1,
    },
    "test_tori": {
        "test_actions_are_constant_and_angles_advance_with_nu": 2,
        "test_narrow_barriers_and_wells_are_seen": 4,
    },
    "test_torus_fit": {
        "test_later_start_is_the_same_torus": 0,
        "test_frequency_errors_cover_those_of_the_scheme": 0,
        "test_separable_bodies_have_their_own_frequencies_and_actions": 1,
        "test_series_converges_with_its_order": 0,
        "test_neo_hookean_torus": 0,
        "test_frequencies_are_the_slopes_of_the_energy": 0,
        "test_regular_orbits_are_never_called_no_tori": 1,
    },
    "test_torus_turns": {
        "test_four_dimensions_have_two_frequencies_and_actions": 0,
    },
    "test_transformed": {
        "test_bounces_off_an_algebraic_wall_keep_the_closed_form": 0,
        "test_compiled_steps_are_the_naive_ones": 1,
        "test_the_trial_takes_a_rate_and_says_it": 0,
    },
    "test_tunes": {
        "test_errors_cover_the_truth": 2,
    },
}
"""By module and test: the number of cases, the first ones, that every change runs."""
