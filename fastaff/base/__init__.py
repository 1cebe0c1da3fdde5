"""What everything stands on: statuses, checks of numbers and arrays, how results are shown, how calls are recorded."""
